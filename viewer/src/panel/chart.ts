/** One chart: values of one unit over simulated time. Drag to zoom, double-click to follow again; the cursor is in all charts. */

import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { curveColours } from '../view/colours';
import type { Frame } from '../protocol/frame';
import type { Shown } from '../values';
import { fixed, make, setText } from './dom';
import { caption, digitsOf } from './figure';
import { WIDE } from './panes';

/** Simulated seconds that are shown while the chart follows, and that are kept. */
const WINDOW = 20;
const KEPT = 600;
/** Heights, px; the last one beside the view, where charts are below each other. */
const HEIGHTS = { least: 100, most: 420, beside: 190 };
const LEAST_WIDTH = 220;
/** Most names of values in an axis title. */
const NAMED = 2;
/** Names of many values of one unit together. */
const QUANTITIES: Record<string, string> = {
  m: 'positions',
  rad: 'angles',
  '°': 'angles',
  'm/s': 'speeds',
  'rad/s': 'rotation',
  'mm/s': 'slip',
  N: 'forces',
};
/** Moments of a log that are nearer to each other than this are one, s. */
const SAME = 0.015;

const AXIS_TITLE = { labelSize: 15, labelGap: 0, labelFont: '11px system-ui, sans-serif' };

/** Value of a robot or an object, drawn as a curve. */
export interface Series {
  /** Robot or object, as `robot 3`. */
  thing: string;
  label: string;
  /** Colour of the robot. */
  colour: string;
  value: Shown;
  /** Reads it from a frame. */
  read: (frame: Frame) => number | null;
}

export class Chart {
  readonly element = make('figure', { class: 'chart' });
  private readonly place = make('div', {});
  private readonly title = make('span', {});
  private series: Series[] = [];
  /** Times, then one column a series. */
  private data: (number | null)[][] = [[]];
  private plot: uPlot | null = null;
  private following = true;
  /** The moment that is shown, where that is not the present, s; and its line. */
  private moment: number | null = null;
  private readonly line = make('i', { class: 'moment' });

  constructor(
    private readonly unit: string,
    close: () => void,
  ) {
    this.element.append(
      caption(this.title, unit || 'numbers', () => this.plot?.ctx.canvas, close),
      this.place,
    );
  }

  has(thing: string, key: string): boolean {
    return this.series.some((series) => series.thing === thing && series.value.key === key);
  }

  get curves(): readonly Series[] {
    return this.series;
  }

  isEmpty(): boolean {
    return this.series.length === 0;
  }

  /** Adds a series with what is known of its past. */
  add(series: Series, past: (readonly [number, number | null])[]): void {
    const [times = []] = this.data;
    if (times.length === 0 && this.series.length === 0) {
      this.data[0] = past.map(([time]) => time);
      this.data.push(past.map(([, number]) => number));
    } else {
      // The number before each time that the chart has.
      let at = 0;
      this.data.push(
        times.map((time) => {
          while (at + 1 < past.length && (past[at + 1]?.[0] ?? Infinity) <= (time ?? 0)) at++;
          return past[at]?.[1] ?? null;
        }),
      );
    }
    this.series.push(series);
    this.build();
  }

  remove(thing: string, key: string): void {
    const index = this.series.findIndex((series) => series.thing === thing && series.value.key === key);
    if (index < 0) return;
    this.series.splice(index, 1);
    this.data.splice(index + 1, 1);
    if (!this.isEmpty()) this.build();
  }

  /** Takes the values of a moment, which may be one between others where a log is played again. */
  push(time: number, read: (series: Series) => number | null): void {
    const times = this.data[0] as number[];
    const at = times.findLastIndex((other) => other <= time) + 1;
    const near = [times[at - 1], times[at]].some((other) => other !== undefined && Math.abs(other - time) < SAME);
    if (near && (at < times.length || times[at - 1] === time)) return;
    times.splice(at, 0, time);
    this.series.forEach((series, index) => this.data[index + 1]?.splice(at, 0, read(series)));
    if (at < times.length - 1 || this.moment !== null) return;
    const old = times.findIndex((other) => other >= time - KEPT);
    if (old > 1000) this.data.forEach((column) => column.splice(0, old));
  }

  /** Forgets what it has; every series has this past. */
  refill(past: (series: Series) => [number, number | null][]): void {
    const columns = this.series.map((series) => past(series));
    this.data = [(columns[0] ?? []).map(([time]) => time), ...columns.map((column) => column.map(([, it]) => it))];
    this.following = true;
  }

  /** Draws a line at the moment that is shown; null while that is the present. */
  showMoment(moment: number | null): void {
    if ((moment === null) !== (this.moment === null)) this.following = true;
    this.moment = moment;
    this.placeLine();
  }

  follow(): void {
    this.following = true;
  }

  draw(): void {
    const [times = []] = this.data as number[][];
    const [first, end] = [times[0] ?? 0, times.at(-1) ?? 0];
    this.plot?.setData(this.data as uPlot.AlignedData, false);
    // The present has a window that moves on; of the past, or of a log, all is shown.
    const min = this.moment === null ? Math.max(0, end - WINDOW) : first;
    if (this.following) this.plot?.setScale('x', { min, max: Math.max(min + 1, end) });
    else this.plot?.redraw();
    this.placeLine();
    this.showNumbers();
  }

  /** Fills the panel's height, as far as the legend leaves it. */
  resize(): void {
    const panel = this.element.closest<HTMLElement>('#plots');
    const legend = this.place.querySelector<HTMLElement>('.u-legend')?.offsetHeight ?? 0;
    const above = panel ? this.place.getBoundingClientRect().top - this.rowTop(panel) : 0;
    const room = WIDE.matches ? HEIGHTS.beside : (panel?.clientHeight ?? 0) - above - legend - 12;
    this.plot?.setSize({ width: this.width(), height: Math.max(HEIGHTS.least, Math.min(HEIGHTS.most, room)) });
    this.placeLine();
  }

  dispose(): void {
    this.plot?.destroy();
    this.element.remove();
  }

  rows(): [number, string, number, string][] {
    const [times = []] = this.data;
    return this.series.flatMap(({ label }, index) =>
      times.flatMap((time, row): [number, string, number, string][] => {
        const number = this.data[index + 1]?.[row];
        return typeof time === 'number' && typeof number === 'number' ? [[time, label, number, this.unit]] : [];
      }),
    );
  }

  private width(): number {
    return Math.max(LEAST_WIDTH, this.place.clientWidth);
  }

  /** The top that the panel would have if this chart were in its first row. */
  private rowTop(panel: HTMLElement): number {
    const first = panel.querySelector('.chart')?.getBoundingClientRect().top ?? 0;
    return panel.getBoundingClientRect().top - panel.scrollTop + this.element.getBoundingClientRect().top - first;
  }

  private placeLine(): void {
    const { plot, moment, line } = this;
    const { min = 0, max = 0 } = plot?.scales.x ?? {};
    const isIn = moment !== null && min <= moment && moment <= max;
    line.hidden = !plot || !isIn;
    if (plot && isIn) line.style.left = `${plot.valToPos(moment, 'x')}px`;
  }

  /** While the pointer is on no chart, the legend has the numbers of the moment that is shown. */
  private showNumbers(): void {
    if (!this.plot || (this.plot.cursor.left ?? -1) >= 0) return;
    const times = this.data[0] as number[];
    const moment = this.moment ?? Infinity;
    this.plot.setLegend({
      idx: Math.max(
        0,
        times.findLastIndex((time) => time <= moment),
      ),
    });
  }

  /** The names of what is plotted, and their unit. */
  private quantity(): string {
    const names = [...new Set(this.series.map(({ value }) => value.name))];
    const shown = names.length > NAMED ? (QUANTITIES[this.unit] ?? 'values') : names.join(', ');
    return this.unit ? `${shown} (${this.unit})` : shown;
  }

  /** A robot's name is left out where all is of one robot. */
  private labels(): string[] {
    const isOne = new Set(this.series.map(({ thing }) => thing)).size === 1;
    return this.series.map(({ label, value }) => (isOne && this.series.length > 2 ? value.name : label));
  }

  private build(): void {
    this.plot?.destroy();
    const [quantity, labels, colours] = [this.quantity(), this.labels(), curveColours(this.series)];
    // Many values leave no room for what the title says.
    const unit = this.unit && this.series.length <= 2 ? ` ${this.unit}` : '';
    setText(this.title, quantity);
    const colour = () => getComputedStyle(document.documentElement).getPropertyValue('--quiet');
    const axis = { stroke: colour, grid: { stroke: '#88888833', width: 1 }, ticks: { show: false } };
    this.plot = new uPlot(
      {
        width: this.width(),
        height: HEIGHTS.least,
        cursor: { sync: { key: 'time' }, drag: { x: true, y: false } },
        scales: { x: { time: false }, y: { range: (_, low, high) => yRange(low, high) } },
        axes: [
          { ...axis, size: 24, label: 'time (s)', ...AXIS_TITLE },
          { ...axis, size: 52, values: (_, splits) => ticks(splits), label: quantity, ...AXIS_TITLE },
        ],
        series: [
          { label: 'time', value: (_, time) => (typeof time === 'number' ? `${time.toFixed(3)} s` : '–') },
          ...this.series.map(({ value }, index) => ({
            label: labels[index] ?? '',
            stroke: colours[index] ?? '#777',
            width: 1.5,
            value: (_: uPlot, number: number | null) =>
              typeof number === 'number' ? `${fixed(number, value.digits)}${unit}` : '–',
            ...(value.key.startsWith('target') ? { dash: [4, 4] } : {}),
          })),
        ],
        hooks: {
          setSelect: [(plot) => plot.select.width > 0 && (this.following = false)],
          ready: [(plot) => plot.over.addEventListener('dblclick', () => (this.following = true))],
        },
      },
      this.data as uPlot.AlignedData,
      this.place,
    );
    this.plot.over.append(this.line);
    this.draw();
    this.resize();
  }
}

/** A quiet value is not blown up until its noise fills the chart. */
function yRange(low: number | null, high: number | null): [number, number] {
  const [least, most] = [low ?? 0, high ?? 0];
  const margin = Math.max((most - least) * 0.08, 0.005 * Math.max(1, Math.abs(most)));
  return [least - margin, most + margin];
}

/** Formats a number with enough digits to tell neighbours apart. */
function ticks(splits: number[]): string[] {
  const step = Math.abs((splits[1] ?? 1) - (splits[0] ?? 0)) || 1;
  return splits.map((split) => fixed(split, digitsOf(step)));
}
