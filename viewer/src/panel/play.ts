/** The bar below: how time passes, which moment is shown, and logs. */

import type { Live } from '../protocol/live';
import type { Playback } from '../playback';
import type { State } from '../state';
import { ask } from './dialog';
import { find, make, setText } from './dom';
import { TimeLine } from './timeline';

/** Time that one press of Step is, s. */
const STEP = 0.01;
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 10];

export class PlayBar {
  private readonly pause = find<HTMLButtonElement>('pause');
  private readonly record = find<HTMLButtonElement>('record');
  private readonly speed = find<HTMLSelectElement>('speed');
  private readonly save = find<HTMLButtonElement>('save');
  private readonly reset = find<HTMLButtonElement>('reset');
  private readonly step = find<HTMLButtonElement>('step');
  private readonly fastest = make('option', { value: '0' }, 'fastest');
  private readonly past = find('past');
  private readonly timeline = new TimeLine(
    (time) => this.playback.goTo(time),
    () => (this.playback.logName === null ? this.playback.goLive() : this.playback.goTo(this.playback.range[1])),
  );
  /** Request to the server, and the button's text. */
  private readonly controls = [this.pause, this.step, this.record, this.save, this.reset].map(
    (button) => [button, button.title] as const,
  );

  constructor(
    private readonly state: State,
    private readonly server: Live,
    private readonly playback: Playback,
  ) {
    this.speed.append(...SPEEDS.map((speed) => make('option', { value: String(speed) }, `${speed} ×`)), this.fastest);
    this.pause.onclick = () => {
      if (playback.mode !== 'live') playback.playOrPause();
      else server.control({ pause: !state.status?.paused });
    };
    this.step.onclick = () => {
      if (playback.mode !== 'live') playback.step(STEP);
      else server.control({ step: Math.max(1, Math.round(STEP / (state.scene?.time_step ?? STEP))) });
    };
    this.reset.onclick = () => void this.resetWorld();
    this.save.onclick = () => server.control('save');
    this.record.onclick = () => server.control({ record: state.status?.recording === null });
    this.speed.onchange = () => {
      if (playback.mode !== 'live') playback.setRate(Number(this.speed.value) || 1);
      else server.control({ speed: Number(this.speed.value) });
    };
    find('live').onclick = () => playback.goLive();
  }

  /** Updates the place of the shown moment in the time that can be shown, a few times a second. */
  updateTime(): void {
    const { frame } = this.state;
    if (!frame) return;
    setText(find('time'), frame.time.toFixed(3));
    this.timeline.update(frame.time, this.playback.range, this.playback.marks, this.playback.late);
  }

  update(): void {
    const { status } = this.state;
    const { mode, isPaused, logName, rate } = this.playback;
    this.past.hidden = mode === 'live';
    find('timeline').toggleAttribute('data-live', mode === 'live');
    const shown = logName === null ? 'the past' : `the log ${logName}`;
    setText(this.past.firstElementChild as HTMLElement, `You are looking at ${shown}. Keys do not drive.`);
    if (!status) return;
    setText(find('mode'), logName ?? (mode === 'past' ? 'past' : isPaused ? 'paused' : 'live'));
    find('mode').dataset.mode = mode === 'live' && isPaused ? 'paused' : mode;
    setText(find('factor'), isPaused ? '0' : (mode === 'live' ? status.real_time_factor : rate).toFixed(2));
    setText(this.pause, !isPaused ? 'Pause' : mode === 'past' ? 'Play' : 'Resume');
    this.pause.setAttribute('aria-pressed', String(isPaused));
    // What is asked of the server is not asked by who looks at a log.
    this.record.disabled = this.save.disabled = this.reset.disabled = logName !== null;
    setText(this.record, status.recording ? 'Stop recording' : 'Record');
    this.record.setAttribute('aria-pressed', String(status.recording !== null));
    for (const [button, title] of this.controls) {
      // Who may not control the world may look at its past.
      const refused = mode === 'live' || button === this.record || button === this.reset ? this.server.refused : null;
      // Not disabled: whoever presses it is told why.
      button.setAttribute('aria-disabled', String(refused !== null && logName === null));
      button.title = logName === null ? (refused ?? title) : title;
    }
    this.speed.disabled = mode === 'live' && this.server.refused !== null;
    this.fastest.disabled = mode !== 'live';
    if (status.recording) this.record.title = status.recording;
    const speed = String(mode === 'live' ? status.speed : rate);
    if (![...this.speed.options].some(({ value }) => value === speed)) {
      this.speed.append(make('option', { value: speed }, `${speed} ×`));
    }
    if (document.activeElement !== this.speed) this.speed.value = speed;
  }

  private async resetWorld(): Promise<void> {
    const agreed = () => othersAgree(this.state, 'Reset the world?', 'go back to their starts', 'Reset');
    // Where this page may not, the server says so; nobody needs to be asked.
    if (this.server.refused || (await agreed())) this.server.control('reset');
  }
}

/** Asks when robots of others would notice; `what` says what becomes of them. */
export async function othersAgree(state: State, title: string, what: string, answer: string): Promise<boolean> {
  const others = state.othersRobots().map(({ id }) => state.nameOf(id));
  if (others.length === 0) return true;
  const shown =
    others.length > 5 ? `${others.slice(0, 5).join(', ')} and ${others.length - 5} more` : others.join(', ');
  return ask(
    title,
    `Robots of other people are here: ${shown}. They ${what}, and everyone is told who did it.`,
    answer,
  );
}
