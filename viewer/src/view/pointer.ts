/** Mouse and fingers on the picture, as turning, shifting and zooming. */

/** Actions of the pointer. Lengths are parts of the picture's height. */
export interface Gestures {
  /** A press begins, with what is under it. */
  begin(x: number, y: number): void;
  turn(x: number, y: number): void;
  pan(x: number, y: number): void;
  /** Times the distance to what is at a point of the screen. */
  zoom(factor: number, x: number, y: number): void;
  hover(x: number, y: number): void;
  leave(): void;
}

/** Zoom of a wheel's step of 100 px. */
const WHEEL = 0.0014;
/** Pixels of a line and of a page of a wheel. */
const WHEEL_UNITS = [1, 18, 400];

export class Pointer {
  /** While something else is dragged. */
  held = false;
  /** True if a drag shifts the picture instead of turning it: seen from above. */
  pansFirst = false;
  private readonly pressed = new Map<number, { x: number; y: number; pans: boolean }>();

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly gestures: Gestures,
  ) {
    canvas.addEventListener('pointerdown', (event) => this.down(event));
    canvas.addEventListener('pointermove', (event) => this.move(event));
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture'] as const) {
      canvas.addEventListener(end, (event) => this.pressed.delete(event.pointerId));
    }
    canvas.addEventListener('pointerleave', () => gestures.leave());
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
  }

  private down(event: PointerEvent): void {
    const { clientX: x, clientY: y, button, pointerId, shiftKey } = event;
    const pans = button !== 0 || shiftKey;
    this.pressed.set(pointerId, { x, y, pans });
    // What is not a pointer of the browser, as in tests, cannot be captured.
    if (event.isTrusted) this.canvas.setPointerCapture(pointerId);
    const points = [...this.pressed.values()];
    const middle = (axis: 'x' | 'y') => points.reduce((sum, point) => sum + point[axis], 0) / points.length;
    if (!this.held) this.gestures.begin(middle('x'), middle('y'));
  }

  private move(event: PointerEvent): void {
    const { clientX: x, clientY: y, pointerId } = event;
    const last = this.pressed.get(pointerId);
    if (!last) {
      if (event.pointerType === 'mouse') this.gestures.hover(x, y);
      return;
    }
    const other = [...this.pressed].find(([id]) => id !== pointerId)?.[1];
    this.pressed.set(pointerId, { ...last, x, y });
    if (this.held) return;
    const [dx, dy] = [(x - last.x) / this.canvas.clientHeight, (y - last.y) / this.canvas.clientHeight];
    if (other) {
      const [before, after] = [Math.hypot(last.x - other.x, last.y - other.y), Math.hypot(x - other.x, y - other.y)];
      // Each of two fingers moves the middle by a half.
      this.gestures.pan(dx / 2, dy / 2);
      if (after > 1) this.gestures.zoom(before / after, (x + other.x) / 2, (y + other.y) / 2);
    } else if (last.pans || this.pansFirst) this.gestures.pan(dx, dy);
    else this.gestures.turn(dx, dy);
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const pixels = event.deltaY * (WHEEL_UNITS[event.deltaMode] ?? 1);
    // A pinch on a touchpad comes as a wheel of small steps with the control key.
    const factor = Math.exp(Math.max(-400, Math.min(400, pixels)) * WHEEL * (event.ctrlKey ? 6 : 1));
    this.gestures.zoom(factor, event.clientX, event.clientY);
  }
}
