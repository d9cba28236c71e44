/** Messages that stand in the view for a few seconds. */

import type { State } from '../state';
import { find, make } from './dom';

/** How long a message stays, ms, and how many do at a time. */
const SHOWN_TIME = 6000;
const MAX_SHOWN = 4;
/** The server reports every few seconds that it is behind its pace. That is shown again after so long, ms, */
const LAG_INTERVAL = 60_000;
/** or when the pace has fallen to less than this part of the one shown last. */
const WORSE = 0.9;
const LAG = /^behind its pace: real-time factor ([\d.]+)/;

export class Toasts {
  private readonly element = find('toasts');
  /** When a lag was shown last, ms, and which part of the desired pace was reached. */
  private lag = { time: -Infinity, part: 1 };

  constructor(private readonly state: State) {}

  show(text: string): void {
    if (this.isKnownLag(text)) return;
    const toast = make('p', {}, text);
    this.element.append(toast);
    while (this.element.childElementCount > MAX_SHOWN) this.element.firstElementChild?.remove();
    setTimeout(() => toast.remove(), SHOWN_TIME);
  }

  private isKnownLag(text: string): boolean {
    const [, reached] = LAG.exec(text) ?? [];
    if (reached === undefined) return false;
    const [time, part] = [performance.now(), Number(reached) / (this.state.status?.speed || 1)];
    if (time - this.lag.time < LAG_INTERVAL && part >= WORSE * this.lag.part) return true;
    this.lag = { time, part };
    return false;
  }
}
