/** The card of the scenario that is played: what to do, its goals, the clock and the stars. */

import { Run, bestTime, clockText, keepBest, starText, starsFor } from '../best';
import type { Frame } from '../protocol/frame';
import type { Pose, Scenario } from '../protocol/scene';
import type { State } from '../state';
import { find, make, setText } from './dom';

/** Requests of the card. */
interface Wishes {
  /** Brings the scenario's robots in. */
  enter(): void;
  /** Starts it again. */
  again(): void;
  /** Shows the other scenarios. */
  others(): void;
  /** Marks goals as reached in the view. */
  reached(goals: string[]): void;
  /** Shows a robot of a class where it was in the best run; null for none. */
  rival(robotClass: string, pose: Pose | null): void;
}

export class Mission {
  private readonly element = find('mission');
  private readonly clock = make('output', { class: 'time', id: 'mission-time' });
  private readonly goals = make('ul', { class: 'goals' });
  private readonly result = make('p', { class: 'result', role: 'status' });
  private readonly enter = make('button', { id: 'mission-enter', class: 'main' }, 'Start');
  private readonly again = make('button', { id: 'mission-again' }, 'Again');
  private readonly others = make('button', { id: 'mission-others' }, 'Other scenarios');
  private shown: Scenario | null = null;
  /** World whose end has been counted; the world of the last status; and the one before the scenario, whose end is another's. */
  private counted = '';
  private last = '';
  private before = '';
  private line = '';
  /** Number of goals that are reached. */
  private reached = 0;
  private run = new Run();
  private best: Run | null = null;

  constructor(
    private readonly state: State,
    private readonly wishes: Wishes,
  ) {
    this.enter.onclick = () => wishes.enter();
    this.again.onclick = () => wishes.again();
    this.others.onclick = () => wishes.others();
  }

  /** Updates the card after the scene, the status or the shown moment has changed. */
  update(): void {
    const { scene, status, isPresent } = this.state;
    const scenario = isPresent ? (scene?.scenario ?? null) : null;
    this.element.hidden = !scenario || !status;
    const world = status ? `${status.scene}/${status.resets}` : '';
    // A scenario comes before the first status of its world.
    if (scenario && status && scenario !== this.shown) this.build(scenario);
    this.last = world;
    if (!scenario || !status) return;
    const [team] = status.league?.teams ?? [];
    const timeLeft = status.league?.time_left ?? scenario.time_limit;
    const finished = world === this.before ? null : (team?.finished ?? null);
    setText(this.clock, clockText(finished ?? scenario.time_limit - timeLeft));
    const reached = new Set(team?.reached ?? []);
    if (reached.size !== this.reached) this.wishes.reached([...reached]);
    this.reached = reached.size;
    for (const goal of this.goals.children) {
      goal.classList.toggle('done', reached.has(goal.getAttribute('data-goal') ?? ''));
    }
    this.enter.hidden = status.robots.length > 0;
    this.again.hidden = status.league?.has_begun !== true;
    this.again.classList.toggle('main', finished !== null || status.league?.is_over === true);
    if (finished !== null && this.counted !== world) {
      this.counted = world;
      this.line = `${starText(starsFor(scenario, finished))} in ${clockText(finished)}.${this.keep(scenario, finished)}`;
    }
    setText(this.result, finished !== null ? this.line : status.league?.is_over ? 'The time is up.' : ready(scenario));
    this.element.classList.toggle('finished', finished !== null);
  }

  /** Takes a frame of the server's world: the first robot's run, beside which the best one goes. */
  takeFrame(frame: Frame): void {
    const [first] = this.shown?.robots ?? [];
    const played = this.state.status?.robots.find((robot) => first && robot.name === first.name);
    const pose = frame.robots.find(({ id }) => id === played?.id)?.pose;
    if (!first || !this.state.isPresent) return;
    if (!pose) return this.wishes.rival(first.class, null);
    const before = this.run.seconds;
    this.run.take(frame.time, pose);
    if (this.run.seconds < before) this.best = Run.best(this.shown?.name ?? '');
    this.wishes.rival(first.class, this.best?.at(this.run.seconds) ?? null);
  }

  /** Keeps the time of a run that was driven from here, and returns how it is among those. */
  private keep({ name }: Scenario, seconds: number): string {
    if (!this.state.status?.robots.some((robot) => this.state.isOwn(robot))) return '';
    const isBest = keepBest(name, seconds, this.run);
    return isBest ? ' Your best.' : ` Your best is ${clockText(bestTime(name) ?? seconds)}.`;
  }

  private build(scenario: Scenario): void {
    if (scenario.name !== this.shown?.name) this.before = this.last;
    this.shown = scenario;
    this.counted = '';
    this.reached = 0;
    [this.run, this.best] = [new Run(), Run.best(scenario.name)];
    const goal = (name: string) => make('li', { 'data-goal': name }, name.replaceAll('-', ' '));
    this.goals.replaceChildren(...scenario.goals.map(goal));
    this.element.replaceChildren(
      make('header', {}, make('h2', {}, scenario.title), this.clock),
      make('p', {}, scenario.text),
      make('p', { class: 'quiet' }, scenario.keys),
      this.goals,
      this.result,
      make('div', { class: 'row' }, this.enter, this.again, this.others),
    );
  }
}

/** Describes what is to be won. */
function ready({ name, stars: [three, two] }: Scenario): string {
  const best = bestTime(name);
  const own = best === null ? '' : ` Your best is ${clockText(best)}.`;
  return `★★★ within ${three} s, ★★ within ${two} s.${own}`;
}
