/** Stopwatch of the graphics card's work at a frame. Drawing calls return before it is done. */

/** Interval between two looks whether it is done, ms. */
const INTERVAL = 2;

/** Returns the frames of a second; null at rest: mostly there was nothing new to draw, or nothing is drawn yet. */
export function frameRate(drawn: number, idle: number): number | null {
  return drawn === 0 || idle > 1.5 * drawn ? null : drawn;
}

export class Stopwatch {
  private pending: { sync: WebGLSync; began: number }[] = [];
  private lastEnd = 0;
  private waiting = false;

  constructor(
    private readonly gl: WebGL2RenderingContext,
    private readonly took: (time: number) => void,
  ) {}

  /** A frame that began then has been given to the card. */
  drawn(began: number): void {
    const sync = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (!sync) return;
    this.gl.flush();
    this.pending.push({ sync, began });
    if (!this.waiting) this.wait();
  }

  /** Frames that are not done. */
  get behind(): number {
    return this.pending.length;
  }

  private wait(): void {
    this.waiting = true;
    setTimeout(() => this.check(), INTERVAL);
  }

  private check(): void {
    const now = performance.now();
    for (let first = this.pending[0]; first; first = this.pending[0]) {
      if (this.gl.getSyncParameter(first.sync, this.gl.SYNC_STATUS) !== this.gl.SIGNALED) break;
      this.gl.deleteSync(first.sync);
      this.pending.shift();
      // It had to wait for the frame before.
      this.took(now - Math.max(first.began, this.lastEnd));
      this.lastEnd = now;
    }
    this.waiting = false;
    if (this.pending.length > 0) this.wait();
  }
}
