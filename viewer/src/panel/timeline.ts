/** The time line: a slider through what can be shown, with times at its ends, marks of what happened and bands of missed real time. */

import type { Late, Mark } from '../marks';
import { find, make, setText } from './dom';

export class TimeLine {
  private readonly slider = find<HTMLInputElement>('timeline');
  private readonly element = find('marks');
  private readonly bands = find('late');
  private shown: Mark[] = [];
  private isHeld = false;

  /** `goLive` returns to the present: the end of the run so far. */
  constructor(
    private readonly goTo: (time: number) => void,
    goLive: () => void,
  ) {
    const { slider } = this;
    slider.oninput = () => (slider.value === slider.max ? goLive() : goTo(Number(slider.value)));
    slider.onpointerdown = () => (this.isHeld = true);
    slider.onpointerup = slider.onpointercancel = slider.onblur = () => (this.isHeld = false);
  }

  /** Shows a moment of a range. */
  update(time: number, [first, last]: [number, number], marks: Mark[], late: readonly Late[]): void {
    this.slider.min = String(first);
    this.slider.max = String(last);
    this.slider.setAttribute('aria-valuetext', `${time.toFixed(1)} s`);
    if (!this.isHeld) this.slider.value = String(time);
    setText(find('first-time'), seconds(first));
    setText(find('last-time'), seconds(last));
    if (marks.length !== this.shown.length || marks.some((mark, index) => mark !== this.shown[index]))
      this.build(marks);
    this.place(first, last);
    this.showLate(late, first, last);
  }

  private showLate(late: readonly Late[], first: number, last: number): void {
    const length = Math.max(1e-9, last - first);
    const within = late.filter(({ to }) => to > first);
    this.bands.replaceChildren(
      ...within.map(({ from, to, factor }) => {
        const title = `${seconds(from)} to ${seconds(to)}: slower than asked for, down to ${factor.toFixed(2)} of real time`;
        const band = make('i', { class: 'late', title });
        const start = Math.max(first, from);
        band.style.left = `${(100 * (start - first)) / length}%`;
        band.style.width = `${(100 * (to - start)) / length}%`;
        return band;
      }),
    );
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
