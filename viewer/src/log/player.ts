/** Plays a log: what a live world tells by itself is read from the file as time goes on. */

import type { Frame, Scan } from '../protocol/frame';
import type { WireLine } from '../protocol/live';
import type { Solid } from '../protocol/scene';
import type { Reading } from '../protocol/sensors';
import type { LogFile, LogRobots } from './file';

/** Receiver of a log's contents. */
export interface LogListener {
  frame(frame: Frame): void;
  /** The objects that the map does not have, by their numbers, when that changes. The frame with them follows. */
  objects(objects: Map<number, Solid>): void;
  /** Takes the robots when they change. */
  status(robots: LogRobots): void;
  scan(scan: Scan): void;
  line(line: WireLine): void;
  reading(reading: Reading): void;
  /** Time has not passed but changed: paths, plots and lines from before are of another time. The frame follows. */
  jumped(): void;
  /** It was played to its end. */
  ended(): void;
  /** The file cannot be read here; it is paused. */
  failed(reason: string): void;
}

/** Interval between two frames, ms, as in a live world. */
const INTERVAL = 33;
/** Longest time whose lines, readings and scans are read for a frame, s. After a jump it is the time before it. */
const LOOK_BACK = 1;

export class Player {
  /** True if lines of the wire are read. */
  wantLines = false;
  /** s */
  time: number;
  private rate = 0;
  /** Wall clock, ms, at which the time was `since.time`. */
  private since = { wall: 0, time: 0 };
  private timer: ReturnType<typeof setTimeout> | undefined;
  /** Number of starts of playing. Work of an earlier start is dropped. */
  private turn = 0;
  private showing: Promise<void> | null = null;
  private isDue = false;
  private isClosed = false;
  private hasJumped = true;
  private shown = 0;
  private robots = '';
  private objects = '';

  constructor(
    readonly log: LogFile,
    private readonly listener: LogListener,
  ) {
    this.time = log.start;
  }

  get isPlaying(): boolean {
    return this.rate > 0;
  }

  /** Plays on, or from the start when it is at the end; `rate` is seconds of the log a second, more than 0. */
  play(rate = 1): void {
    if (this.time >= this.log.end) {
      this.time = this.log.start;
      this.hasJumped = true;
    }
    const wasPlaying = this.isPlaying;
    this.rate = rate;
    this.since = { wall: performance.now(), time: this.time };
    if (!wasPlaying) void this.tick(++this.turn);
  }

  pause(): void {
    this.rate = 0;
    clearTimeout(this.timer);
  }

  /** Ends it: the listener is told nothing more, also of what is being read. */
  close(): void {
    this.pause();
    this.isClosed = true;
  }

  /** Goes to a time, s; plays on from there if it was playing. Of several that come faster than they are read the last counts. */
  seek(time: number): Promise<void> {
    this.hasJumped = true;
    return this.goTo(time);
  }

  /** Pauses, and goes on by some seconds, or back. */
  step(seconds: number): Promise<void> {
    this.pause();
    if (seconds < 0) this.hasJumped = true;
    return this.goTo(this.time + seconds);
  }

  private goTo(time: number): Promise<void> {
    this.time = Math.min(this.log.end, Math.max(this.log.start, time));
    this.since = { wall: performance.now(), time: this.time };
    return this.show();
  }

  private async tick(turn: number): Promise<void> {
    const { wall, time } = this.since;
    this.time = Math.min(this.log.end, time + (this.rate * (performance.now() - wall)) / 1000);
    await this.show();
    if (turn !== this.turn || !this.isPlaying) return;
    if (this.time >= this.log.end) {
      this.pause();
      this.listener.ended();
    } else {
      this.timer = setTimeout(() => void this.tick(turn), INTERVAL);
    }
  }

  /** Shows the time that it is; what is asked for meanwhile is shown right after. */
  private show(): Promise<void> {
    this.isDue = true;
    this.showing ??= this.showDue().finally(() => (this.showing = null));
    return this.showing;
  }

  private async showDue(): Promise<void> {
    while (this.isDue) {
      this.isDue = false;
      try {
        await this.showNow();
      } catch (reason) {
        this.pause();
        if (!this.isClosed) this.listener.failed(reason instanceof Error ? reason.message : String(reason));
      }
    }
  }

  private async showNow(): Promise<void> {
    const [time, hasJumped] = [this.time, this.hasJumped];
    this.hasJumped = false;
    const after = hasJumped ? time - LOOK_BACK : Math.max(this.shown, time - LOOK_BACK);
    this.shown = time;
    const [{ frame, robots, spawned }, readings, scans, lines] = await Promise.all([
      this.log.momentAt(time),
      this.log.readingsBetween(after, time),
      this.log.scansBetween(after, time),
      this.wantLines ? this.log.linesBetween(after, time) : [],
    ]);
    if (this.isClosed) return;
    if (hasJumped) this.listener.jumped();
    const seen = JSON.stringify(robots);
    if (seen !== this.robots) {
      this.robots = seen;
      this.listener.status(robots);
    }
    const numbers = [...spawned.keys()].join();
    if (numbers !== this.objects) {
      this.objects = numbers;
      this.listener.objects(spawned);
    }
    for (const line of lines) this.listener.line(line);
    for (const reading of readings) this.listener.reading(reading);
    this.listener.frame(frame);
    for (const scan of scans) this.listener.scan(scan);
  }
}
