/** Events for the time line: robots that came and left, resets, saves and recordings. */

import type { Past } from './protocol/frame';
import type { Status } from './protocol/live';

export interface Mark {
  /** s */
  time: number;
  kind: 'robot' | 'world' | 'recording';
  what: string;
}

/** Time in which the world was slower than it was asked to be, s. */
export interface Late {
  from: number;
  to: number;
  /** Least real-time factor. */
  factor: number;
}

/** Part of the requested speed that counts as reached. */
const ENOUGH = 0.9;
/** Times that are nearer to each other are one, s. */
const GAP = 1.5;
/** Most times that are kept. */
const MOST_LATE = 200;

export type Seen = Pick<Status, 'robots' | 'resets' | 'saves' | 'recording'>;

export class Marks {
  list: Mark[] = [];
  late: Late[] = [];
  private before: Seen | null = null;

  /** Compares the world with how it was before. */
  take(time: number, now: Seen): void {
    const { before } = this;
    this.before = now;
    if (!before) return;
    if (now.resets !== before.resets) {
      this.list = [{ time: 0, kind: 'world', what: 'The world was reset' }];
      this.late = [];
      return;
    }
    const missing = (one: Seen, other: Seen) =>
      one.robots.filter(({ id }) => !other.robots.some((robot) => robot.id === id));
    for (const robot of missing(now, before)) this.add(time, 'robot', `${nameOf(robot)} came`);
    for (const robot of missing(before, now)) this.add(time, 'robot', `${nameOf(robot)} left`);
    if (now.saves > before.saves) this.add(time, 'world', 'The world was saved');
    if (now.recording !== before.recording) {
      this.add(time, 'recording', now.recording ? 'Recording started' : 'Recording stopped');
    }
  }

  /** Adds what happened before a time, s, at which the page was opened. */
  takePast(robots: Past['robots'], opened: number): void {
    const events = robots.flatMap(({ robot: id, came, left, ...known }) => {
      const name = nameOf({ id, ...known });
      return [
        { time: came, what: `${name} came` },
        { time: left, what: `${name} left` },
      ];
    });
    const earlier = events
      .filter(({ time }) => time > 0 && time < opened)
      .toSorted((one, other) => one.time - other.time);
    this.list = [...earlier.map((event) => ({ ...event, kind: 'robot' as const })), ...this.list];
  }

  /** Notes whether the world keeps the speed that it was asked for. */
  takePace(time: number, { paused, speed, real_time_factor: factor }: Status): void {
    if (paused || speed === 0 || time === 0 || factor >= ENOUGH * speed) return;
    const last = this.late.at(-1);
    const goesOn = last !== undefined && time - last.to < GAP * speed;
    // The factor is that of the last half second.
    const from = goesOn ? last.from : Math.max(0, time - factor / 2);
    const now = { from, to: time, factor: goesOn ? Math.min(last.factor, factor) : factor };
    this.late = [...(goesOn ? this.late.slice(0, -1) : this.late), now].slice(-MOST_LATE);
  }

  clear(): void {
    [this.list, this.before, this.late] = [[], null, []];
  }

  private add(time: number, kind: Mark['kind'], what: string): void {
    this.list = [...this.list, { time, kind, what }];
  }
}

function nameOf({ name, class: robotClass, id }: Pick<Status['robots'][number], 'name' | 'class' | 'id'>): string {
  return name || `${robotClass} #${id}`;
}
