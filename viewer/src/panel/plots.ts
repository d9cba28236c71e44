/** Plots of any values over time, one chart a unit; what was plotted can be zoomed, read off and saved. */

import type { Frame } from '../protocol/frame';
import type { State } from '../state';
import { type Value, valuesOf } from '../values';
import { Chart, type Series } from './chart';
import { find, make, save } from './dom';

export class PlotsPanel {
  private readonly element = find('plots');
  private readonly charts = make('div', { id: 'charts' });
  private readonly hint = make('p', { class: 'quiet' }, 'Click a value in World to plot it here.');
  private readonly byUnit = new Map<string, Chart>();
  private moment: number | null = null;

  constructor(
    private readonly state: State,
    private readonly past: () => Frame[],
  ) {
    const first = make('button', { type: 'button', id: 'plot-first' }, 'Position, speeds and slip');
    first.onclick = () => this.plotFirst();
    const all = make('button', { type: 'button' }, 'Show all');
    all.onclick = () => this.byUnit.forEach((chart) => chart.follow());
    const csv = make('button', { type: 'button', id: 'save-csv' }, 'Save CSV');
    csv.onclick = () => save(new Blob([this.csv()], { type: 'text/csv' }), 'usarsim-plots.csv');
    const clear = make('button', { type: 'button' }, 'Clear');
    clear.onclick = () => this.clear();
    this.element.append(
      make('div', { class: 'row' }, make('h2', {}, 'Plots'), first, all, csv, clear, this.hint),
      this.charts,
    );
    const observer = new ResizeObserver(() => this.resize());
    [this.charts, this.element].forEach((element) => observer.observe(element));
  }

  has(robot: number, key: string): boolean {
    return [...this.byUnit.values()].some((chart) => chart.has(robot, key));
  }

  /** Plots a value, or no longer. */
  toggle(robot: number, value: Value): void {
    const chart = this.byUnit.get(value.unit);
    if (chart?.has(robot, value.key)) {
      chart.remove(robot, value.key);
      if (chart.isEmpty()) this.close(value.unit);
    } else {
      const label = `${this.state.nameOf(robot)} ${value.name}`;
      this.add({ robot, label, colour: this.state.colourOf(robot), value });
    }
    this.hint.hidden = this.byUnit.size > 0;
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
    return this.byUnit.size === 0;
  }

  /** Takes the values of a frame; they are kept while the plots are hidden, too. */
  push(frame: Frame): void {
    this.byUnit.forEach((chart) => chart.push(frame.time, (series) => this.read(series, frame)));
  }

  /** Fills the plots anew: another world is shown, or more of a log is known. */
  refill(): void {
    const past = this.past();
    this.byUnit.forEach((chart) => chart.refill((series) => this.pastOf(series, past)));
  }

  /** Marks the moment that is shown; null while that is the present. */
  showMoment(moment: number | null): void {
    this.byUnit.forEach((chart) => chart.showMoment(moment));
    this.moment = moment;
  }

  /** Draws what has come; to be called a few times a second. */
  draw(): void {
    if (!this.element.hidden) this.byUnit.forEach((chart) => chart.draw());
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
    return past.map((frame) => [frame.time, series.value.isReading ? null : this.read(series, frame)]);
  }

  /** One fills the width, several share it. */
  private resize(): void {
    this.byUnit.forEach((chart) => chart.resize());
  }

  private read({ robot, value }: Series, frame: Frame): number | null {
    const robotState = frame.robots.find(({ id }) => id === robot);
    return robotState ? value.read(robotState, this.state.sensorsOf(robot)) : null;
  }

  private close(unit: string): void {
    this.byUnit.get(unit)?.dispose();
    this.byUnit.delete(unit);
    this.resize();
    this.hint.hidden = this.byUnit.size > 0;
  }

  private clear(): void {
    [...this.byUnit.keys()].forEach((unit) => this.close(unit));
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
