/** The time line: a slider through what can be shown, with times at its ends and marks of what happened. */

import type { Mark } from '../marks';
import { find, make, setText } from './dom';

export class TimeLine {
  private readonly slider = find<HTMLInputElement>('timeline');
  private readonly element = find('marks');
  private shown: Mark[] = [];
  private isHeld = false;

  constructor(private readonly goTo: (time: number) => void) {
    const { slider } = this;
    slider.oninput = () => goTo(Number(slider.value));
    slider.onpointerdown = () => (this.isHeld = true);
    slider.onpointerup = slider.onpointercancel = slider.onblur = () => (this.isHeld = false);
  }

  /** Shows a moment of a range. */
  update(time: number, [first, last]: [number, number], marks: Mark[]): void {
    this.slider.min = String(first);
    this.slider.max = String(last);
    this.slider.setAttribute('aria-valuetext', `${time.toFixed(1)} s`);
    if (!this.isHeld) this.slider.value = String(time);
    setText(find('first-time'), seconds(first));
    setText(find('last-time'), seconds(last));
    if (marks.length !== this.shown.length || marks.some((mark, index) => mark !== this.shown[index]))
      this.build(marks);
    this.place(first, last);
  }

  private build(marks: Mark[]): void {
    this.shown = marks;
    this.element.replaceChildren(
      ...marks.map(({ time, kind, what }) => {
        const mark = make('i', { class: 'mark', 'data-kind': kind, title: `${seconds(time)}: ${what}` });
        mark.onclick = () => this.goTo(time);
        return mark;
      }),
    );
  }

  private place(first: number, last: number): void {
    const length = Math.max(1e-9, last - first);
    this.shown.forEach(({ time }, index) => {
      const mark = this.element.children[index] as HTMLElement;
      mark.style.left = `${(100 * (Math.max(first, Math.min(last, time)) - first)) / length}%`;
    });
  }
}

/** Formats a time shortly: 12.3 s, 4:05. */
function seconds(time: number): string {
  if (time < 100) return `${time.toFixed(1)} s`;
  const whole = Math.floor(time);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, '0')}`;
}
