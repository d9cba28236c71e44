/** The best runs of scenarios, which this browser keeps. */

import { remember, remembered } from './panel/dom';
import type { Pose, Scenario } from './protocol/scene';

/** Interval between two poses of a run, s, and most of them: ten minutes. */
const INTERVAL = 0.2;
const MOST = 3000;

/** Returns the best time of a scenario, s; null before the first. */
export function bestTime(scenario: string): number | null {
  const seconds = Number.parseFloat(remembered(`best.${scenario}`) ?? '');
  return Number.isFinite(seconds) ? seconds : null;
}

/** Keeps a time and its run if it is better than all before. Returns true if it is. */
export function keepBest(scenario: string, seconds: number, run: Run): boolean {
  const before = bestTime(scenario);
  if (before !== null && before <= seconds) return false;
  remember(`best.${scenario}`, seconds.toFixed(2));
  remember(
    `run.${scenario}`,
    JSON.stringify(run.poses.map((pose) => pose.map((part) => Math.round(part * 1e3) / 1e3))),
  );
  return true;
}

/** The run of the first robot of a scenario: its poses at an interval. */
export class Run {
  private began: number | null = null;
  private last = 0;

  constructor(readonly poses: Pose[] = []) {}

  /** Returns the best run that this browser has of a scenario; null without one. */
  static best(scenario: string): Run | null {
    try {
      const poses: unknown = JSON.parse(remembered(`run.${scenario}`) ?? 'null');
      const isGood = Array.isArray(poses) && poses.every((pose) => Array.isArray(pose) && pose.length === 7);
      return isGood ? new Run(poses as Pose[]) : null;
    } catch {
      return null;
    }
  }

  /** Takes the robot's pose at a simulated time, s. An earlier time than before begins another run. */
  take(time: number, pose: Pose): void {
    if (this.began === null || time < this.last) {
      this.began = time;
      this.poses.length = 0;
    }
    this.last = time;
    if (this.poses.length < MOST && time >= this.began + this.poses.length * INTERVAL) this.poses.push(pose);
  }

  /** Time since the run began, s. */
  get seconds(): number {
    return this.last - (this.began ?? 0);
  }

  /** Returns the pose at a time since the run began, s; null after its end. */
  at(seconds: number): Pose | null {
    const at = seconds / INTERVAL;
    const [before, after] = [this.poses[Math.floor(at)], this.poses[Math.floor(at) + 1]];
    if (!before || !after) return null;
    const part = at - Math.floor(at);
    // Two rotations so near each other are mixed as numbers; theirs may have opposite signs.
    const sign = [3, 4, 5, 6].reduce((sum, i) => sum + before[i]! * after[i]!, 0) < 0 ? -1 : 1;
    const mixed = before.map((value, i) => value * (1 - part) + after[i]! * part * (i < 3 ? 1 : sign));
    const length = Math.hypot(...mixed.slice(3));
    return mixed.map((value, i) => (i < 3 ? value : value / length)) as Pose;
  }
}

/** Returns the stars for a time: three, two, or one for any. */
export function starsFor({ stars: [three, two] }: Pick<Scenario, 'stars'>, seconds: number): number {
  return seconds <= three ? 3 : seconds <= two ? 2 : 1;
}

/** Draws stars as a text of three. */
export const starText = (count: number): string => '★'.repeat(count) + '☆'.repeat(3 - count);

/** Formats seconds as minutes, seconds and tenths. */
export function clockText(seconds: number): string {
  const tenths = Math.round(10 * seconds);
  const [minutes, rest] = [Math.floor(tenths / 600), tenths % 600];
  return `${minutes}:${String(Math.floor(rest / 10)).padStart(2, '0')}.${rest % 10}`;
}
