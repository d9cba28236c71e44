/** A plot of values against each other, or of what a laser sees: points in a plane, both axes alike if their units are. */

import { fixed, make } from './dom';
import { caption, digitsOf } from './figure';

/** Most points of a curve. */
const MOST = 4000;
/** Rooms beside the plane for numbers, px. */
const ROOM = { left: 44, right: 8, top: 6, bottom: 30 };
const HEIGHT = 260;
/** Lines of an axis, about. */
const LINES = 5;

export interface Axis {
  name: string;
  unit: string;
}

export class Plane {
  readonly element = make('figure', { class: 'chart' });
  private readonly canvas = make('canvas');
  private points: [number, number][] = [];

  /** Draws x to the right and y up; `isCurve` joins the points, and the last one is marked. */
  constructor(
    title: string,
    private readonly axes: readonly [Axis, Axis],
    private readonly colour: string,
    private readonly isCurve: boolean,
    close: () => void,
  ) {
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', `${title}: ${axes.map(({ name }) => name).join(' to the right, ')} up`);
    this.element.append(
      caption(make('span', {}, title), title, () => this.canvas, close),
      this.canvas,
    );
  }

  /** Adds a point; of many, each second one is left out. */
  push(x: number, y: number): void {
    this.points.push([x, y]);
    if (this.points.length > MOST) this.points = this.points.filter((_, index) => index % 2 === 0);
  }

  set(points: [number, number][]): void {
    this.points = points.slice(0, MOST);
  }

  draw(): void {
    const width = Math.max(220, this.element.clientWidth - 4);
    const ratio = window.devicePixelRatio;
    Object.assign(this.canvas, { width: width * ratio, height: HEIGHT * ratio });
    this.canvas.style.height = `${HEIGHT}px`;
    const context = this.canvas.getContext('2d');
    if (!context) return;
    context.scale(ratio, ratio);
    const style = getComputedStyle(this.element);
    const inner = [width - ROOM.left - ROOM.right, HEIGHT - ROOM.top - ROOM.bottom] as const;
    const [across, up] = this.ranges(inner);
    const place = ([x, y]: [number, number]): [number, number] => [
      ROOM.left + ((x - across[0]) / (across[1] - across[0])) * inner[0],
      ROOM.top + inner[1] - ((y - up[0]) / (up[1] - up[0])) * inner[1],
    ];
    context.font = '11px Inter, system-ui, sans-serif';
    context.fillStyle = style.getPropertyValue('--quiet');
    context.strokeStyle = '#88888833';
    context.beginPath();
    context.textAlign = 'center';
    for (const [x, step] of ticks(across)) {
      const [at] = place([x, up[0]]);
      context.moveTo(at, ROOM.top);
      context.lineTo(at, ROOM.top + inner[1]);
      context.fillText(fixed(x, digitsOf(step)), at, ROOM.top + inner[1] + 12);
    }
    context.textAlign = 'right';
    for (const [y, step] of ticks(up)) {
      const [, at] = place([across[0], y]);
      context.moveTo(ROOM.left, at);
      context.lineTo(ROOM.left + inner[0], at);
      context.fillText(fixed(y, digitsOf(step)), ROOM.left - 4, at + 4);
    }
    context.stroke();
    const named = ({ name, unit }: Axis) => (unit ? `${name} (${unit})` : name);
    context.textAlign = 'center';
    context.fillText(named(this.axes[0]), ROOM.left + inner[0] / 2, HEIGHT - 4);
    context.save();
    context.translate(10, ROOM.top + inner[1] / 2);
    context.rotate(-Math.PI / 2);
    context.fillText(named(this.axes[1]), 0, 0);
    context.restore();
    const places = this.points.map(place);
    context.strokeStyle = context.fillStyle = this.colour;
    context.lineWidth = 1.5;
    if (this.isCurve) {
      context.beginPath();
      places.forEach(([x, y]) => context.lineTo(x, y));
      context.stroke();
    }
    for (const [x, y] of this.isCurve ? places.slice(-1) : places) {
      context.beginPath();
      context.arc(x, y, this.isCurve ? 4 : 1.5, 0, 2 * Math.PI);
      context.fill();
    }
  }

  /** Ranges of both axes with a margin. Axes of one unit have one scale. */
  private ranges([width, height]: readonly [number, number]): [[number, number], [number, number]] {
    const [across, up] = [0, 1].map((axis) => {
      const numbers = this.points.map((point) => point[axis]!);
      const [least, most] = numbers.reduce(
        ([least, most], number) => [Math.min(least, number), Math.max(most, number)],
        [Infinity, -Infinity],
      );
      if (least > most) return [0, 1];
      const margin = Math.max(0.05 * (most - least), 1e-3 * Math.max(1, Math.abs(most)));
      return [least - margin, most + margin];
    }) as [[number, number], [number, number]];
    if (this.axes[0].unit !== this.axes[1].unit) return [across, up];
    const each = Math.max((across[1] - across[0]) / width, (up[1] - up[0]) / height);
    const about = ([least, most]: [number, number], length: number): [number, number] => {
      const middle = (least + most) / 2;
      return [middle - (each * length) / 2, middle + (each * length) / 2];
    };
    return [about(across, width), about(up, height)];
  }
}

/** Returns round numbers within a range, each with their distance. */
function ticks([least, most]: [number, number]): [number, number][] {
  const rough = (most - least) / LINES;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = ([1, 2, 5].find((factor) => factor * power >= rough) ?? 10) * power;
  const first = Math.ceil(least / step);
  return Array.from({ length: Math.floor(most / step) - first + 1 }, (_, index) => [(first + index) * step, step]);
}
