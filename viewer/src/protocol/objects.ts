/** Asks the server for the objects that the map does not have, one question at a time: they may change with every frame. */

import type { Spawned } from './scene';

export class ObjectQuestions {
  private isStale = false;
  private isAsking = false;
  /** Number of the world that is asked about. */
  private world = 0;

  constructor(
    private readonly answered: (objects: Spawned[]) => void,
    private readonly failed: () => void,
    private readonly fetch: () => Promise<Spawned[]>,
  ) {}

  /** Asks as soon as the last question is answered. */
  ask(): void {
    this.isStale = true;
    if (!this.isAsking) void this.askNow();
  }

  /** Begins with another world. Answers to earlier questions are dropped. */
  restart(): void {
    this.world += 1;
    [this.isStale, this.isAsking] = [false, false];
  }

  private async askNow(): Promise<void> {
    const { world } = this;
    this.isAsking = true;
    try {
      while (this.isStale) {
        this.isStale = false;
        const objects = await this.fetch();
        if (world !== this.world) return;
        this.answered(objects);
      }
      this.isAsking = false;
    } catch {
      if (world !== this.world) return;
      this.isAsking = false;
      this.failed();
    }
  }
}
