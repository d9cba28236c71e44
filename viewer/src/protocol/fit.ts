/** Asks the server whether a robot could stand somewhere: one question at a time, and not many a second. */

import type { Fit, FitAnswer } from './live.gen';

export type { Fit, FitAnswer } from './live.gen';

/** Least time between two questions, ms. */
const INTERVAL = 100;
/** A question without an answer is forgotten after this time, ms. */
const PATIENCE = 2000;

export class FitQuestions {
  private waiting: Fit | null = null;
  private asked: Fit | null = null;
  private askedAt = -Infinity;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly send: (fit: Fit) => void,
    private readonly answered: (answer: FitAnswer) => void,
  ) {}

  /** Asks as soon as the server is free; of several questions meanwhile the last one counts. */
  ask(fit: Fit): void {
    this.waiting = fit;
    this.next();
  }

  take(answer: FitAnswer): void {
    this.asked = null;
    this.answered(answer);
    this.next();
  }

  /** Begins with another connection. */
  restart(): void {
    [this.waiting, this.asked] = [null, null];
  }

  private next(): void {
    clearTimeout(this.timer);
    if (!this.waiting) return;
    const since = performance.now() - this.askedAt;
    const wait = (this.asked ? PATIENCE : INTERVAL) - since;
    if (wait > 0) {
      this.timer = setTimeout(() => this.next(), wait);
      return;
    }
    [this.asked, this.waiting, this.askedAt] = [this.waiting, null, performance.now()];
    this.send(this.asked);
  }
}
