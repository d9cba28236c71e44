/** The tab of live plots of the selected robot. */

import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { type RobotState, rollPitchYaw } from '../protocol/frame';
import type { RobotClass } from '../protocol/scene';
import type { State } from '../state';
import { COLOURS } from '../view/overlay';
import { find, make } from './dom';

/** Simulated seconds that are shown. */
const WINDOW = 20;
/** Height of a plot, px. */
const HEIGHT = 150;

interface Chart {
  title: string;
  series: (robot: RobotClass) => string[];
  dashed?: (index: number) => boolean;
  read: (state: RobotState, robot: RobotClass) => number[];
}

const CHARTS: Chart[] = [
  {
    title: 'Pose: x and y in m, yaw in rad',
    series: () => ['x', 'y', 'yaw'],
    read: ({ pose }) => [pose[0], pose[1], rollPitchYaw(pose)[2]],
  },
  {
    title: 'Wheel speeds, rad/s: measured, and target (dashed)',
    series: ({ wheels }) => wheels.flatMap(({ name }) => [name, `${name} target`]),
    dashed: (index) => index % 2 === 1,
    read: ({ wheels }) => wheels.flatMap(({ speed, target }) => [speed, target]),
  },
  {
    title: 'Slip, mm/s: velocity by the wheels minus velocity of the robot',
    series: () => ['forward', 'right'],
    read: slip,
  },
];

/** By the textbook's kinematics, in which a Mecanum wheel has endlessly many rollers. */
function slip({ wheels, linear }: RobotState, robot: RobotClass): number[] {
  const speeds = wheels.map(({ speed }) => speed);
  const [frontLeft = 0, frontRight = 0, backLeft = 0, backRight = 0] = speeds;
  const forward = (robot.wheel_radius * speeds.reduce((sum, speed) => sum + speed, 0)) / Math.max(1, speeds.length);
  const isOmni = robot.steering === 'OmniDrive';
  const right = isOmni ? (robot.wheel_radius * (frontLeft - frontRight - backLeft + backRight)) / 4 : 0;
  return [1000 * (forward - linear[0]), 1000 * (right - linear[1])];
}

export class PlotsPanel {
  private plots: { chart: Chart; plot: uPlot; data: number[][] }[] = [];
  private readonly element = find('plots');
  private robot: number | null = null;
  private last = -1;

  constructor(private readonly state: State) {
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  /** A frame has come. Values are kept while the tab is hidden, too. */
  update(): void {
    const { selected, frame } = this.state;
    const robot = this.state.robotState(selected);
    const robotClass = this.state.classOf(selected);
    if (!frame || !robot || !robotClass) {
      if (this.robot !== null || this.element.childElementCount === 0) this.empty();
      return;
    }
    if (selected !== this.robot || frame.time < this.last) this.build(robotClass);
    this.robot = selected;
    if (frame.time === this.last) return;
    this.last = frame.time;
    for (const { chart, data } of this.plots) {
      [frame.time, ...chart.read(robot, robotClass)].forEach((value, column) => data[column]?.push(value));
      const old = (data[0] ?? []).findIndex((time) => time >= frame.time - WINDOW);
      if (old > 100) data.forEach((column) => column.splice(0, old));
    }
  }

  /** Draws what has come; to be called a few times a second. */
  draw(): void {
    if (this.element.hidden) return;
    const end = this.last;
    for (const { plot, data } of this.plots) {
      plot.setData(data as uPlot.AlignedData, false);
      plot.setScale('x', { min: Math.max(0, end - WINDOW), max: Math.max(1, end) });
    }
  }

  private empty(): void {
    this.robot = null;
    this.plots.forEach(({ plot }) => plot.destroy());
    this.plots = [];
    this.element.replaceChildren(
      make('p', { class: 'quiet' }, 'Choose a robot: its pose, wheels and slip are drawn here.'),
    );
  }

  private build(robot: RobotClass): void {
    this.plots.forEach(({ plot }) => plot.destroy());
    this.element.replaceChildren();
    this.plots = CHARTS.map((chart) => {
      const names = chart.series(robot);
      const place = make('div', { class: 'plot' });
      const legend = make('div', { class: 'row legend' });
      this.element.append(make('h2', {}, chart.title), legend, place);
      const colour = () => getComputedStyle(document.documentElement).getPropertyValue('--quiet');
      const axis = { stroke: colour, grid: { stroke: '#88888833', width: 1 }, ticks: { show: false } };
      const data: number[][] = [[], ...names.map(() => [])];
      const colourOf = (index: number) => COLOURS[chart.dashed ? Math.floor(index / 2) : index] ?? '#777';
      names.forEach((name, index) => {
        if (chart.dashed?.(index)) return;
        const entry = make('small', {}, name);
        entry.style.borderBottomColor = colourOf(index);
        legend.append(entry);
      });
      const plot = new uPlot(
        {
          width: this.width(),
          height: HEIGHT,
          cursor: { show: false },
          legend: { show: false },
          scales: { x: { time: false } },
          axes: [
            { ...axis, size: 28 },
            { ...axis, size: 50 },
          ],
          series: [
            { label: 's' },
            ...names.map((label, index) => ({
              label,
              stroke: colourOf(index),
              width: 1.5,
              ...(chart.dashed?.(index) ? { dash: [4, 4] } : {}),
            })),
          ],
        },
        data as uPlot.AlignedData,
        place,
      );
      return { chart, plot, data };
    });
  }

  private width(): number {
    return Math.max(200, this.element.clientWidth - 22);
  }

  private resize(): void {
    if (this.element.clientWidth > 0)
      this.plots.forEach(({ plot }) => plot.setSize({ width: this.width(), height: HEIGHT }));
  }
}
