/** A stick on the screen: x and y from -1 to 1, by mouse or finger. */

import { make } from './dom';

export class Stick {
  readonly element: HTMLElement;
  /** True if it moves to the side as well. */
  sideways = true;
  x = 0;
  y = 0;
  private readonly knob = make('span');

  constructor(
    private readonly onlySideways: boolean,
    private readonly moved: () => void,
  ) {
    const style = onlySideways ? 'stick wide' : 'stick';
    const what = onlySideways ? 'turn' : 'move';
    this.element = make(
      'div',
      { class: style, 'data-stick': what, role: 'group', 'aria-label': `stick: ${what}` },
      this.knob,
    );
    this.element.onpointerdown = (event) => {
      this.element.setPointerCapture(event.pointerId);
      this.follow(event);
    };
    this.element.onpointermove = (event) => this.element.hasPointerCapture(event.pointerId) && this.follow(event);
    this.element.onpointerup = this.element.onpointercancel = () => {
      this.release();
      this.moved();
    };
  }

  release(): void {
    this.set(0, 0);
  }

  private follow(event: PointerEvent): void {
    const { left, top, width, height } = this.element.getBoundingClientRect();
    const reach = width / 2 - 20;
    const x = this.sideways ? (event.clientX - left - width / 2) / reach : 0;
    const y = this.onlySideways ? 0 : (event.clientY - top - height / 2) / reach;
    const length = Math.max(1, Math.hypot(x, y));
    this.set(x / length, y / length);
    this.moved();
  }

  private set(x: number, y: number): void {
    this.x = x;
    this.y = y;
    const reach = this.element.clientWidth / 2 - 20;
    this.knob.style.transform = `translate(${x * reach}px, ${y * reach}px)`;
  }
}
