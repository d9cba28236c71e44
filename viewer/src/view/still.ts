/**
 * A still picture at the best quality, which covers the view once nothing has moved for a while. It is drawn in strips, so a hand that moves
 * the view waits for one of them at most.
 */

import type { Stage } from './stage';

/** Time without motion after which it is drawn, ms. */
const REST = 250;
/** Pixels of a strip, with a graphics card and without one: the memory that it takes there, and 0.4 s here. */
const STRIP = { hardware: 1_500_000, software: 150_000 };
/** Most pixels along one of the page's pixels. */
const FINEST = 2;

export class Still {
  private readonly canvas = document.createElement('canvas');
  private state: 'none' | 'drawn' | 'shown' = 'none';
  /** Time of the last motion, ms, and the number of motions. */
  private moved = performance.now();
  private motions = 0;

  constructor(
    private readonly view: HTMLCanvasElement,
    private readonly stage: Stage,
    /** Places everything with all its details. */
    private readonly refine: () => void,
  ) {
    this.canvas.className = 'view-still';
    this.canvas.setAttribute('aria-hidden', 'true');
    view.after(this.canvas);
  }

  /** True if it is shown, or is being drawn. */
  get isBegun(): boolean {
    return this.state !== 'none';
  }

  get isShown(): boolean {
    return this.state === 'shown';
  }

  /** Something moves: gives way to the moving picture. */
  stir(): void {
    this.moved = performance.now();
    this.motions++;
    this.state = 'none';
    this.canvas.classList.remove('shown');
  }

  /** Nothing moves at this time, ms. */
  rest(now: number): void {
    if (this.state === 'none' && this.stage.canImprove && now - this.moved > REST) void this.draw();
  }

  private async draw(): Promise<void> {
    this.state = 'drawn';
    const { motions } = this;
    const ratio = Math.min(FINEST, window.devicePixelRatio);
    const [width, height] = [this.view.clientWidth, this.view.clientHeight].map((length) => Math.round(length * ratio));
    const context = this.canvas.getContext('2d', { alpha: false });
    if (!width || !height || !context) return;
    Object.assign(this.canvas, { width, height });
    const strips = Math.ceil((width * height) / (this.stage.isSoftware ? STRIP.software : STRIP.hardware));
    const rows = Math.ceil(height / strips);
    this.refine();
    for (let first = 0; first < height; first += rows) {
      const pixels = await this.stage.rows(first, { width, height, rows, ratio });
      // What has moved meanwhile would be torn.
      if (motions !== this.motions) return;
      context.putImageData(new ImageData(upright(pixels, width), width), 0, first);
    }
    this.state = 'shown';
    this.canvas.classList.add('shown');
  }
}

/** Rows of pixels from the top, as pictures have them, of rows from below. */
function upright(pixels: Uint8Array, width: number): Uint8ClampedArray<ArrayBuffer> {
  const turned = new Uint8ClampedArray(pixels.length);
  const length = 4 * width;
  for (let row = 0; row < pixels.length; row += length) {
    turned.set(pixels.subarray(pixels.length - row - length, pixels.length - row), row);
  }
  return turned;
}
