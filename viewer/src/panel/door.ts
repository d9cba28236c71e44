/** The first screen: scenarios as cards, with a living view of the one that is chosen. */

import { bestTime, clockText, starText, starsFor } from '../best';
import { readLink } from '../link';
import type { Playback } from '../playback';
import type { ScenarioCard } from '../protocol/scene';
import type { Status } from '../protocol/live';
import type { Transport } from '../protocol/transport';
import type { State } from '../state';
import { find, make } from './dom';
import './scenarios.css';

/** Time for which a card has to be chosen before its demo is fetched, ms. Each is work for the server. */
const PATIENCE = 400;
/** Key of this tab's memory that somebody has left the screen. */
const LEFT = 'usarsim.door';
/** Pause between the end of a demo and its next start, ms. */
const PAUSE = 1500;

/** Uses of what is chosen. */
interface Uses {
  /** Begins a scenario. */
  start(scenario: string): void;
  /** The reason why this page may not begin one. */
  refused(): string | null;
  openLog(): void;
  say(text: string): void;
}

export class Door {
  private readonly element = find('door');
  private readonly about = make('div', { class: 'about' });
  private readonly cards = make('div', { class: 'cards', role: 'group', 'aria-label': 'Scenarios' });
  private readonly start = make('button', { id: 'door-start', class: 'main' }, 'Start');
  private readonly watch = make('button', { id: 'door-watch' }, 'Watch it done');
  private readonly enter = make('button', { id: 'door-enter', title: 'Leave the scenarios (Esc)' });
  private scenarios: ScenarioCard[] = [];
  private chosen: ScenarioCard | null = null;
  private isOpen = false;
  /** True once somebody has left it in this tab, or came by a link to something else. */
  private wasLeft = sessionStorage.getItem(LEFT) !== null || readLink(location.hash) !== null;
  /** The scenario whose demo is opened or shown behind the cards. */
  private shown: ScenarioCard | null = null;
  /** Robots of the server's world, now and at the last look. */
  private robots = 0;
  private robotsBefore = 0;
  /** Fetches the chosen scenario's demo. */
  private timer: ReturnType<typeof setTimeout> | undefined;
  /** Starts a demo again that has ended. */
  private repeating: ReturnType<typeof setTimeout> | undefined;
  private readonly demos = new Map<string, Promise<File>>();

  constructor(
    private readonly state: State,
    private readonly playback: Playback,
    private readonly transport: Transport,
    private readonly uses: Uses,
  ) {
    const open = make('button', { id: 'door-log' }, 'Open a log');
    open.onclick = () => uses.openLog();
    this.enter.onclick = () => this.leave();
    this.start.onclick = () => this.chosen && this.begin(this.chosen);
    this.watch.onclick = () => this.chosen && void this.watchDemo(this.chosen);
    const bring = 'or drop a map (.world, .sdf, .glb), a robot (.urdf) or a log (.mcap) anywhere';
    this.element.append(
      this.about,
      this.cards,
      make('div', { class: 'row ways' }, this.enter, open, make('span', { class: 'quiet' }, bring)),
    );
    find('scenarios').onclick = () => this.show();
    window.addEventListener('keydown', (event) => {
      if (event.key === 'Escape' && this.isOpen && !document.querySelector('dialog[open]')) this.leave();
    });
  }

  /** Asks the server for its scenarios. A server of another version has none. */
  async load(): Promise<void> {
    this.scenarios = await this.transport.scenarios().catch(() => []);
    if (this.scenarios.length === 0) return;
    this.cards.replaceChildren(...this.scenarios.map((card) => this.card(card)));
    // A link to a scenario: #scenario=stairs.
    const asked = new URLSearchParams(location.hash.slice(1)).get('scenario');
    this.chosen = this.scenarios.find(({ name }) => name === asked) ?? null;
    if (this.chosen) this.wasLeft = false;
    this.update();
  }

  /** Takes the state of the server's world, also while a demo is shown. */
  takeStatus({ robots }: Status): void {
    this.robots = robots.length;
    this.update();
  }

  /** Opens or closes after the world, its robots or the shown moment have changed. */
  update(): void {
    const { scene, isWatched } = this.state;
    // A league stays on its map.
    const isContest = scene?.league !== null && scene?.scenario === null;
    find('scenarios').hidden = this.scenarios.length === 0 || isWatched || isContest;
    const isIdle = this.robots === 0 && !isWatched && scene !== null;
    // Somebody has come, by a controller or from another page.
    if (this.isOpen && this.robots > this.robotsBefore) return this.close();
    this.robotsBefore = this.robots;
    const isFirst = !this.wasLeft && this.playback.mode === 'live' && scene?.league === null;
    if (!this.isOpen && isFirst && isIdle && this.scenarios.length > 0) this.show();
    if (this.hasEnded) this.repeat();
  }

  /** True if the chosen scenario's demo has been played to its end, and no other one is on its way. */
  private get hasEnded(): boolean {
    const { mode, isPaused } = this.playback;
    return this.isOpen && this.shown !== null && this.shown === this.chosen && mode === 'log' && isPaused;
  }

  /** Shows the scenarios, whatever is in the world. */
  show(): void {
    const [first] = this.scenarios;
    if (!first || this.isOpen || find('scenarios').hidden) return;
    this.isOpen = true;
    this.element.hidden = false;
    document.documentElement.dataset.door = 'open';
    this.enter.textContent = `Continue in ${this.state.scene?.map.name ?? 'the world'}`;
    this.choose(this.chosen ?? first);
  }

  /** Returns to the world as it is. */
  private leave(): void {
    this.wasLeft = true;
    sessionStorage.setItem(LEFT, 'left');
    this.close();
  }

  private close(): void {
    clearTimeout(this.timer);
    this.isOpen = false;
    this.element.hidden = true;
    delete document.documentElement.dataset.door;
    if (this.shown) this.playback.goLive();
    this.shown = null;
  }

  private begin({ name }: ScenarioCard): void {
    const refused = this.uses.refused();
    if (refused !== null) return this.uses.say(`Not begun: ${refused}`);
    this.leave();
    this.uses.start(name);
  }

  /** Plays the demo as any log, with the bar of time and the lines of the wire. */
  private async watchDemo(card: ScenarioCard): Promise<void> {
    const demo = await this.demo(card);
    if (!demo || !this.isOpen) return;
    this.shown = null;
    this.close();
    await this.playback.open(demo);
  }

  private choose(card: ScenarioCard): void {
    if (this.chosen === card && this.shown === card) return;
    this.chosen = card;
    for (const other of this.cards.children) {
      other.setAttribute('aria-pressed', String(other.getAttribute('data-scenario') === card.name));
    }
    const best = bestTime(card.name);
    const [three, two] = card.stars;
    const own = best === null ? '' : ` · your best ${clockText(best)}`;
    this.watch.hidden = !card.demo;
    this.about.replaceChildren(
      make('h2', {}, card.title),
      make('p', {}, card.text),
      make('p', { class: 'quiet' }, `${[...new Set(card.robots)].join(', ')} on ${card.map} · ${card.keys}`),
      make('p', { class: 'quiet' }, `★★★ within ${three} s, ★★ within ${two} s${own}`),
      make('div', { class: 'row' }, this.start, this.watch),
    );
    clearTimeout(this.timer);
    if (card.demo && this.shown !== card) this.timer = setTimeout(() => void this.preview(card), PATIENCE);
  }

  /** Plays the demo behind the cards. */
  private async preview(card: ScenarioCard): Promise<void> {
    const demo = await this.demo(card);
    if (!demo || !this.isOpen || this.chosen !== card) return;
    this.shown = card;
    await this.playback.open(demo);
  }

  /** Starts a demo that has ended again. */
  private repeat(): void {
    this.repeating ??= setTimeout(() => {
      this.repeating = undefined;
      if (this.hasEnded) this.playback.playOrPause();
    }, PAUSE);
  }

  private demo({ name }: ScenarioCard): Promise<File | null> {
    const known = this.demos.get(name) ?? this.transport.demo(name);
    this.demos.set(name, known);
    return known.catch((error: unknown) => {
      this.demos.delete(name);
      this.uses.say(error instanceof Error ? error.message : String(error));
      return null;
    });
  }

  private card(card: ScenarioCard): HTMLButtonElement {
    const best = bestTime(card.name);
    const button = make(
      'button',
      { class: 'scenario', 'data-scenario': card.name, 'aria-pressed': 'false' },
      ...(card.picture ? [make('img', { src: `scenario/${card.name}/picture.jpg`, alt: '', loading: 'lazy' })] : []),
      make('strong', {}, card.title),
      make('small', {}, best === null ? '☆☆☆' : starText(starsFor(card, best))),
    );
    button.onclick = button.onfocus = button.onpointerenter = () => this.choose(card);
    button.ondblclick = () => this.begin(card);
    return button;
  }
}
