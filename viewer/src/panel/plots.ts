/** Plots of any values over time, one chart a unit; what was plotted can be zoomed, read off and saved. */

import { type Frame, type Scan, isHit } from '../protocol/frame';
import type { State } from '../state';
import { type PoseValue, type Value, valuesOf } from '../values';
import { beamAngle } from '../view/overlay';
import { type Axis, Plane } from './plane';
import { Chart, type Series } from './chart';
import { find, make, save, setText } from './dom';

/** Colour of an object's first curve. */
const OBJECT_COLOUR = '#8a8f98';

/** Receivers of what a plane shows. */
interface Feed {
  push?: (frame: Frame) => void;
  refill?: () => void;
  scan?: (scan: Scan) => void;
}

export class PlotsPanel {
  private readonly element = find('plots');
  private readonly charts = make('div', { id: 'charts' });
  private readonly hint = make('p', { class: 'quiet' }, 'Click a value in World to plot it here.');
  private readonly byUnit = new Map<string, Chart>();
  private readonly planes = new Map<Plane, Feed>();
  private readonly axes = ['right', 'up'].map((way) => make('select', { 'aria-label': `Value that goes ${way}` }));
  private readonly planeOf = make('span', { class: 'row plane', hidden: '' });
  /** Axes that a person has chosen. */
  private readonly chosen = new Set<HTMLSelectElement>();
  private moment: number | null = null;

  constructor(
    private readonly state: State,
    private readonly past: () => Frame[],
  ) {
    const first = make('button', { type: 'button', id: 'plot-first' }, 'Position, speeds and slip');
    first.onclick = () => this.plotFirst();
    const scan = make('button', { type: 'button', id: 'plot-laser' }, 'Laser');
    scan.onclick = () => this.addScan();
    const plane = make('button', { type: 'button', id: 'plot-against' }, 'Plot');
    plane.onclick = () => this.addPlane();
    this.axes.forEach((select) => (select.onchange = () => this.chosen.add(select)));
    const [across, up] = this.axes;
    if (across && up) this.planeOf.append(up, ' against ', across, plane);
    const all = make('button', { type: 'button' }, 'Show all');
    all.onclick = () => this.byUnit.forEach((chart) => chart.follow());
    const csv = make('button', { type: 'button', id: 'save-csv' }, 'Save CSV');
    csv.onclick = () => save(new Blob([this.csv()], { type: 'text/csv' }), 'usarsim-plots.csv');
    const clear = make('button', { type: 'button' }, 'Clear');
    clear.onclick = () => this.clear();
    this.element.append(
      make('div', { class: 'row' }, make('h2', {}, 'Plots'), first, scan, all, csv, clear, this.planeOf, this.hint),
      this.charts,
    );
    const observer = new ResizeObserver(() => this.resize());
    [this.charts, this.element].forEach((element) => observer.observe(element));
  }

  has(robot: number, key: string): boolean {
    return this.shows(`robot ${robot}`, key);
  }

  hasOfObject(object: number, key: string): boolean {
    return this.shows(`object ${object}`, key);
  }

  /** Plots a value of a robot, or no longer. */
  toggle(robot: number, value: Value): void {
    const read = (frame: Frame) => {
      const robotState = frame.robots.find(({ id }) => id === robot);
      return robotState ? value.read(robotState, this.state.sensorsOf(robot)) : null;
    };
    const label = `${this.state.nameOf(robot)} ${value.name}`;
    this.toggleSeries({ thing: `robot ${robot}`, label, colour: this.state.colourOf(robot), value, read });
  }

  /** Plots a value of an object, or no longer. */
  toggleOfObject(object: number, value: PoseValue): void {
    const read = (frame: Frame) => {
      const there = frame.objects.find(({ number }) => number === object);
      return there ? value.read(there) : null;
    };
    const label = `${this.state.object(object)?.name ?? 'object'} ${value.name}`;
    this.toggleSeries({ thing: `object ${object}`, label, colour: OBJECT_COLOUR, value, read });
  }

  private shows(thing: string, key: string): boolean {
    return [...this.byUnit.values()].some((chart) => chart.has(thing, key));
  }

  private toggleSeries(series: Series): void {
    const { thing, value } = series;
    const chart = this.byUnit.get(value.unit);
    if (chart?.has(thing, value.key)) {
      chart.remove(thing, value.key);
      if (chart.isEmpty()) this.close(value.unit);
    } else this.add(series);
    this.showOffers();
  }

  private get curves(): Series[] {
    return [...this.byUnit.values()].flatMap((chart) => chart.curves);
  }

  /** Offers what is plotted for the axes of a plane. */
  private showOffers(): void {
    this.hint.hidden = this.byUnit.size > 0 || this.planes.size > 0;
    const { curves } = this;
    this.planeOf.hidden = curves.length < 2;
    for (const [index, select] of this.axes.entries()) {
      const before = this.chosen.has(select) ? select.value : null;
      select.replaceChildren(
        ...curves.map(({ thing, label, value }) => make('option', { value: `${thing}/${value.key}` }, label)),
      );
      if (before !== null) select.value = before;
      if (before === null || select.selectedIndex < 0) select.selectedIndex = Math.min(index, curves.length - 1);
    }
  }

  /** Plots one of the plotted values against another. */
  private addPlane(): void {
    const [x, y] = this.axes.map((select) => this.curves[select.selectedIndex]);
    if (!x || !y) return;
    const [across, up] = [x, y].map(({ label, value }) => ({ name: label, unit: value.unit })) as [Axis, Axis];
    const title = `${y.label} against ${x.label}`;
    const plane = new Plane(title, [across, up], y.colour, true, () => this.closePlane(plane));
    const push = (frame: Frame) => {
      const [right, high] = [x.read(frame), y.read(frame)];
      if (right !== null && high !== null) plane.push(right, high);
    };
    const isReading = x.value.isReading || y.value.isReading;
    const refill = () => {
      plane.set([]);
      if (!isReading) this.past().forEach(push);
    };
    refill();
    this.show(plane, { push, refill });
  }

  /** Plots what the selected robot's laser sees, ahead up. */
  private addScan(): void {
    const { selected } = this.state;
    const sensors = this.state.classOf(selected)?.sensors ?? [];
    const index = sensors.findIndex(({ fan }) => fan !== null);
    const { fan, name, max_range: range } = sensors[index] ?? {};
    if (selected === null || !fan || !range) {
      this.hint.hidden = false;
      return setText(this.hint, 'The chosen robot has no laser.');
    }
    const title = `${this.state.nameOf(selected)} ${name}`;
    const axes = ['right', 'ahead'].map((name) => ({ name, unit: 'm' })) as [Axis, Axis];
    const plane = new Plane(title, axes, this.state.colourOf(selected), false, () => this.closePlane(plane));
    const scan = (scan: Scan) => {
      if (scan.robot !== selected || scan.sensor !== index) return;
      const ends = scan.ranges.flatMap((part, beam): [number, number][] => {
        const angle = beamAngle(fan, beam);
        return isHit(part) ? [[part * range * Math.sin(angle), part * range * Math.cos(angle)]] : [];
      });
      plane.set([[0, 0], ...ends]);
    };
    this.show(plane, { scan });
  }

  private show(plane: Plane, feed: Feed): void {
    this.planes.set(plane, feed);
    this.charts.prepend(plane.element);
    this.showOffers();
    this.resize();
  }

  private closePlane(plane: Plane): void {
    plane.element.remove();
    this.planes.delete(plane);
    this.showOffers();
    this.resize();
  }

  /** Takes what a laser measured. */
  takeScan(scan: Scan): void {
    this.planes.forEach((feed) => feed.scan?.(scan));
  }

  /** Plots position, speeds and slip of the selected robot, unless something is plotted already. */
  plotFirst(): void {
    const { selected } = this.state;
    const robotClass = this.state.classOf(selected);
    if (selected === null || !robotClass) return;
    const groups = valuesOf(robotClass, this.state.sensorsOf(selected));
    const values = groups.flatMap(({ values }) => values);
    const wanted = (key: string) =>
      ['x', 'y', 'slip forward', 'slip right'].includes(key) || /^(speed|target)\d+$/.test(key);
    values
      .filter(({ key }) => wanted(key) && !this.has(selected, key))
      .forEach((value) => this.toggle(selected, value));
  }

  isEmpty(): boolean {
    return this.byUnit.size === 0 && this.planes.size === 0;
  }

  /** Takes the values of a frame; they are kept while the plots are hidden, too. */
  push(frame: Frame): void {
    this.byUnit.forEach((chart) => chart.push(frame.time, ({ read }) => read(frame)));
    this.planes.forEach((feed) => feed.push?.(frame));
  }

  /** Fills the plots anew: another world is shown, or more of a log is known. */
  refill(): void {
    const past = this.past();
    this.byUnit.forEach((chart) => chart.refill((series) => this.pastOf(series, past)));
    this.planes.forEach((feed) => feed.refill?.());
  }

  /** Marks the moment that is shown; null while that is the present. */
  showMoment(moment: number | null): void {
    this.byUnit.forEach((chart) => chart.showMoment(moment));
    this.moment = moment;
  }

  /** Draws what has come; to be called a few times a second. */
  draw(): void {
    if (this.element.hidden) return;
    this.byUnit.forEach((chart) => chart.draw());
    this.planes.forEach((_, plane) => plane.draw());
  }

  private add(series: Series): void {
    const { unit } = series.value;
    let chart = this.byUnit.get(unit);
    if (!chart) {
      chart = new Chart(unit, () => this.close(unit));
      this.byUnit.set(unit, chart);
      this.charts.append(chart.element);
      this.resize();
    }
    chart.add(series, this.pastOf(series, this.past()));
    chart.showMoment(this.moment);
  }

  /** Values of frames. Readings are known from when the page listens to them. */
  private pastOf(series: Series, past: Frame[]): [number, number | null][] {
    return past.map((frame) => [frame.time, series.value.isReading ? null : series.read(frame)]);
  }

  /** One fills the width, several share it. */
  private resize(): void {
    this.byUnit.forEach((chart) => chart.resize());
  }

  private close(unit: string): void {
    this.byUnit.get(unit)?.dispose();
    this.byUnit.delete(unit);
    this.resize();
    this.showOffers();
  }

  private clear(): void {
    [...this.byUnit.keys()].forEach((unit) => this.close(unit));
    [...this.planes.keys()].forEach((plane) => this.closePlane(plane));
  }

  /** Writes all charts as one table with a line for each number. */
  private csv(): string {
    const rows = [...this.byUnit.values()].flatMap((chart) => chart.rows());
    const quoted = (text: string) => `"${text.replaceAll('"', '""')}"`;
    return [
      'time_s,value,number,unit',
      ...rows.map(([time, name, number, unit]) => `${time},${quoted(name)},${number},${quoted(unit)}`),
    ].join('\n');
  }
}
