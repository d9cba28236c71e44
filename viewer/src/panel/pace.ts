/** Says that the world is slower than it was asked to be: by a colour, a word and, when that is pressed, advice. */

import type { Status } from '../protocol/live';
import { showDialog } from './dialog';
import { find, make } from './dom';

/** Part of the wanted real-time factor that counts as reached. */
const REACHED = 0.95;
/** A world that is slow for less long is not worth a word, ms. */
const PATIENCE = 3000;

export class Pace {
  private readonly sign = find<HTMLButtonElement>('slow');
  private status: Status | null = null;
  /** Since when the world is too slow, ms. */
  private since: number | null = null;

  constructor() {
    this.sign.onclick = () => void showDialog('Slower than real time', make('p', {}, this.explained()), advice());
  }

  /** Takes how fast the world is; null while something else is shown. */
  update(status: Status | null): void {
    this.status = status;
    const isBehind =
      status !== null && !status.paused && status.speed > 0 && status.real_time_factor < REACHED * status.speed;
    this.since = isBehind ? (this.since ?? performance.now()) : null;
    const isShown = this.since !== null && performance.now() - this.since >= PATIENCE;
    this.sign.hidden = !isShown;
    this.sign.title = isShown ? this.explained() : '';
    this.sign.parentElement?.classList.toggle('slow', isShown);
  }

  private explained(): string {
    const { real_time_factor: reached = 0, speed = 1 } = this.status ?? {};
    return (
      `The computer is too busy: the world runs at ${reached.toFixed(2)} times real time instead of ${speed}. ` +
      'Nothing is computed less exactly, it only takes longer.'
    );
  }
}

function advice(): HTMLElement {
  const list = [
    'Remove robots that nobody needs, and close pages that nobody looks at.',
    'Choose a lower speed in the bar at the bottom.',
    'Close other programs on the computer that runs the server.',
    'Who starts the server can choose a faster drive model (--drive-model analytic) or a larger time step (--dt).',
  ];
  return make('ul', {}, ...list.map((text) => make('li', {}, text)));
}
