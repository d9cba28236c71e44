/** The time line: a slider through what can be shown, with times at its ends, marks of what happened and bands of missed real time. */

import type { Late, Mark } from '../marks';
import { find, make, setText } from './dom';

/** Times that are nearer are one, s. */
const SAME = 1e-6;

export class TimeLine {
  private readonly slider = find<HTMLInputElement>('timeline');
  private readonly dots = find('marks');
  private readonly bands = find('late');
  /** Marks and bands that are shown. */
  private marks: Mark[] = [];
  private late: readonly Late[] = [];
  private isHeld = false;

  /** `goLive` returns to the present: the end of the run so far. */
  constructor(
    private readonly goTo: (time: number) => void,
    goLive: () => void,
  ) {
    const { slider } = this;
    // Browsers round the value and the end of a slider, each in its own way.
    const isAtEnd = () => slider.valueAsNumber >= Number(slider.max) - SAME;
    slider.oninput = () => (isAtEnd() ? goLive() : goTo(slider.valueAsNumber));
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
    if (differ(marks, this.marks)) this.buildMarks(marks);
    if (differ(late, this.late)) this.buildLate(late);
    const length = Math.max(1e-9, last - first);
    const at = (time: number) => (100 * (Math.max(first, Math.min(last, time)) - first)) / length;
    this.marks.forEach(({ time }, index) => ((this.dots.children[index] as HTMLElement).style.left = `${at(time)}%`));
    this.late.forEach(({ from, to }, index) => {
      const { style } = this.bands.children[index] as HTMLElement;
      style.left = `${at(from)}%`;
      style.width = `${at(to) - at(from)}%`;
      style.visibility = to > first ? '' : 'hidden';
    });
  }

  private buildMarks(marks: Mark[]): void {
    this.marks = marks;
    this.dots.replaceChildren(
      ...marks.map(({ time, kind, what }) => {
        const mark = make('i', { class: 'mark', 'data-kind': kind, title: `${seconds(time)}: ${what}` });
        mark.onclick = () => this.goTo(time);
        return mark;
      }),
    );
  }

  private buildLate(late: readonly Late[]): void {
    this.late = late;
    this.bands.replaceChildren(
      ...late.map(({ from, to, factor }) => {
        const title = `${seconds(from)} to ${seconds(to)}: slower than asked for, down to ${factor.toFixed(2)} of real time`;
        return make('i', { class: 'late', title });
      }),
    );
  }
}

/** True if two lists do not have the same things. */
function differ(one: readonly unknown[], other: readonly unknown[]): boolean {
  return one.length !== other.length || one.some((thing, index) => thing !== other[index]);
}

/** Formats a time shortly: 12.3 s, 4:05. */
function seconds(time: number): string {
  if (time < 100) return `${time.toFixed(1)} s`;
  const whole = Math.floor(time);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, '0')}`;
}
