/** Windows over the view: a heading to drag them by, a corner to make them larger, keys for both. */

import { find, make } from './dom';

/** Pixels of a press of an arrow key. */
const STEP = 16;
/** Directions of arrow keys: right and down. */
const MOVES: Record<string, readonly [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};
/** Least width of a window, pixels. */
const LEAST = 120;

export class Inset {
  readonly element: HTMLElement;
  private readonly view = find('view');

  /** Shows something in a window; `twice` hears a double click on it, `closed` that somebody has closed it. */
  constructor(title: string, content: HTMLElement, twice: () => void, closed: () => void) {
    const close = make('button', { class: 'plain icon', 'aria-label': `Close ${title}` }, '✕');
    close.onclick = () => closed();
    const heading = make(
      'header',
      { tabindex: '0', title: 'Drag it; arrow keys move it, + and − change its size' },
      make('h2', {}, title),
      close,
    );
    this.element = make('section', { class: 'inset', 'aria-label': title }, heading, content);
    content.ondblclick = twice;
    heading.onkeydown = (event) => this.key(event);
    heading.onpointerdown = (event) => this.drag(heading, event);
    this.view.append(this.element);
    const others = this.view.querySelectorAll('.inset').length - 1;
    this.moveTo(8 + 24 * others, this.view.clientHeight - this.element.offsetHeight - 40 - 24 * others);
  }

  remove(): void {
    this.element.remove();
  }

  private drag(heading: HTMLElement, { target, clientX, clientY, pointerId }: PointerEvent): void {
    if (target instanceof Element && target.closest('button')) return;
    const { offsetLeft, offsetTop } = this.element;
    heading.setPointerCapture(pointerId);
    heading.onpointermove = (event) =>
      this.moveTo(offsetLeft + event.clientX - clientX, offsetTop + event.clientY - clientY);
    heading.onpointerup = heading.onpointercancel = () => (heading.onpointermove = null);
  }

  private key(event: KeyboardEvent): void {
    const { offsetLeft, offsetTop, offsetWidth } = this.element;
    const [x, y] = MOVES[event.key] ?? [0, 0];
    const wider = { '+': 1, '-': -1 }[event.key] ?? 0;
    if (x === 0 && y === 0 && wider === 0) return;
    event.preventDefault();
    event.stopPropagation();
    this.element.style.width = `${Math.max(LEAST, offsetWidth + wider * 2 * STEP)}px`;
    this.moveTo(offsetLeft + STEP * x, offsetTop + STEP * y);
  }

  /** Moves it, but never out of the view. */
  private moveTo(x: number, y: number): void {
    const { clientWidth, clientHeight } = this.view;
    const within = (at: number, most: number) => `${Math.max(0, Math.min(most, at))}px`;
    this.element.style.left = within(x, clientWidth - this.element.offsetWidth);
    this.element.style.top = within(y, clientHeight - this.element.offsetHeight);
  }
}
