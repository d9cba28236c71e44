/** Events for the time line: robots that came and left, resets, saves and recordings. */

import type { Status } from './protocol/live';

export interface Mark {
  /** s */
  time: number;
  kind: 'robot' | 'world' | 'recording';
  what: string;
}

export type Seen = Pick<Status, 'robots' | 'resets' | 'saves' | 'recording'>;

export class Marks {
  list: Mark[] = [];
  private before: Seen | null = null;

  /** Compares the world with how it was before. */
  take(time: number, now: Seen): void {
    const { before } = this;
    this.before = now;
    if (!before) return;
    if (now.resets !== before.resets) {
      this.list = [{ time: 0, kind: 'world', what: 'The world was reset' }];
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

  clear(): void {
    [this.list, this.before] = [[], null];
  }

  private add(time: number, kind: Mark['kind'], what: string): void {
    this.list = [...this.list, { time, kind, what }];
  }
}

function nameOf({ name, class: robotClass, id }: Status['robots'][number]): string {
  return name || `${robotClass} #${id}`;
}
