/** One chart: values of one unit over simulated time. Drag to zoom, double-click to follow again; the cursor is in all charts. */

import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { COLOURS } from '../view/overlay';
import { fixed, make, save } from './dom';
import type { Series } from './plots';

/** Simulated seconds that are shown while the chart follows, and that are kept. */
const WINDOW = 20;
const KEPT = 600;
const HEIGHT = 150;
const LEAST_WIDTH = 220;

export class Chart {
  readonly element = make('figure', { class: 'chart' });
  private readonly place = make('div', {});
  private series: Series[] = [];
  /** Times, then one column a series. */
  private data: (number | null)[][] = [[]];
  private plot: uPlot | null = null;
  private following = true;

  constructor(
    private readonly unit: string,
    close: () => void,
  ) {
    const picture = make(
      'button',
      { type: 'button', class: 'plain icon', title: 'Save as PNG', 'aria-label': `Save ${unit} as PNG` },
      '⤓',
    );
    picture.onclick = () => this.plot?.ctx.canvas.toBlob((blob) => blob && save(blob, 'usarsim-plot.png'));
    const cross = make('button', { type: 'button', class: 'plain icon', 'aria-label': `Close ${unit}` }, '✕');
    cross.onclick = close;
    this.element.append(
      make('figcaption', {}, unit || 'numbers', make('span', { class: 'space' }), picture, cross),
      this.place,
    );
  }

  has(robot: number, key: string): boolean {
    return this.series.some((series) => series.robot === robot && series.value.key === key);
  }

  isEmpty(): boolean {
    return this.series.length === 0;
  }

  /** Adds a series with what is known of its past. */
  add(series: Series, past: (readonly [number, number | null])[]): void {
    const [times = []] = this.data;
    if (times.length === 0) {
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

  remove(robot: number, key: string): void {
    const index = this.series.findIndex((series) => series.robot === robot && series.value.key === key);
    if (index < 0) return;
    this.series.splice(index, 1);
    this.data.splice(index + 1, 1);
    this.build();
  }

  push(time: number, read: (series: Series) => number | null): void {
    this.data[0]?.push(time);
    this.series.forEach((series, index) => this.data[index + 1]?.push(read(series)));
    const old = (this.data[0] ?? []).findIndex((at) => (at ?? 0) >= time - KEPT);
    if (old > 1000) this.data.forEach((column) => column.splice(0, old));
  }

  /** Time has gone back. */
  restart(): void {
    this.data.forEach((column) => (column.length = 0));
    this.following = true;
  }

  follow(): void {
    this.following = true;
  }

  draw(): void {
    const end = this.data[0]?.at(-1) ?? 0;
    this.plot?.setData(this.data as uPlot.AlignedData, false);
    if (this.following) this.plot?.setScale('x', { min: Math.max(0, end - WINDOW), max: Math.max(1, end) });
  }

  resize(): void {
    this.plot?.setSize({ width: this.width(), height: HEIGHT });
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

  private build(): void {
    this.plot?.destroy();
    const colour = () => getComputedStyle(document.documentElement).getPropertyValue('--quiet');
    const axis = { stroke: colour, grid: { stroke: '#88888833', width: 1 }, ticks: { show: false } };
    this.plot = new uPlot(
      {
        width: this.width(),
        height: HEIGHT,
        cursor: { sync: { key: 'time' }, drag: { x: true, y: false } },
        scales: { x: { time: false }, y: { range: (_, low, high) => yRange(low, high) } },
        axes: [
          { ...axis, size: 26 },
          { ...axis, size: 56, values: (_, splits) => ticks(splits) },
        ],
        series: [
          { label: 's', value: (_, time) => (typeof time === 'number' ? time.toFixed(3) : '–') },
          ...this.series.map(({ label, value }, index) => ({
            label,
            stroke: COLOURS[index % COLOURS.length] ?? '#777',
            width: 1.5,
            value: (_: uPlot, number: number | null) =>
              typeof number === 'number' ? fixed(number, value.digits) : '–',
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
    this.draw();
  }
}

/** A quiet value is not blown up until its noise fills the chart. */
function yRange(low: number | null, high: number | null): [number, number] {
  const [least, most] = [low ?? 0, high ?? 0];
  const margin = Math.max((most - least) * 0.08, 0.005 * Math.max(1, Math.abs(most)));
  return [least - margin, most + margin];
}

/** As many digits as tell neighbours apart. */
function ticks(splits: number[]): string[] {
  const step = Math.abs((splits[1] ?? 1) - (splits[0] ?? 0)) || 1;
  const digits = Math.max(0, Math.min(6, Math.ceil(-Math.log10(step) - 1e-9)));
  return splits.map((split) => fixed(split, digits));
}
