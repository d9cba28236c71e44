/** Frames of the run, so that one can look back while the world goes on: the last minute whole, and the rest in steps that grow. */

import { type Frame, readMessage } from './protocol/frame';

/** Newest frames that are all kept: a minute of 30 a second. */
const WHOLE = 1800;
/** Most frames that are kept. */
const KEPT = 5400;
/** Bytes that they may take together: fewer are kept of a world with many robots. */
const MOST_BYTES = 64 << 20;

/** First time between two old frames, s. */
const FIRST_STEP = 0.05;
/** Frames are dropped until so many of them are left, so that it is done seldom. */
const ENOUGH = 0.8;

interface Kept {
  time: number;
  bytes: ArrayBuffer;
}

export class History {
  private frames: Kept[] = [];
  /** Time between two old frames, s. */
  private step = FIRST_STEP;
  private bytes = 0;

  add(time: number, bytes: ArrayBuffer): void {
    const last = this.frames.at(-1)?.time ?? -Infinity;
    if (time === last) return;
    // A world that began anew.
    if (time < last) this.clear();
    this.frames.push({ time, bytes });
    this.bytes += bytes.byteLength;
    this.limit();
  }

  /** Adds frames of the time before the first one, the oldest first. */
  prepend(frames: readonly ArrayBuffer[]): void {
    const first = this.frames[0]?.time ?? Infinity;
    const known = frames.flatMap((bytes) => {
      const time = read(bytes)?.time;
      return time !== undefined && time < first ? [{ time, bytes }] : [];
    });
    this.frames = [...known, ...this.frames];
    this.bytes += known.reduce((sum, { bytes }) => sum + bytes.byteLength, 0);
    this.limit();
  }

  private limit(): void {
    while (this.frames.length > 2 && (this.frames.length > KEPT || this.bytes > MOST_BYTES)) this.thin();
  }

  /** Keeps fewer frames of the time before the last minute, or before the newest half where a minute is too much. */
  private thin(): void {
    let thinner = this.apart();
    // What has become old since was thinned as before: that is not enough for long.
    if (thinner.length > ENOUGH * this.frames.length) {
      this.step *= 2;
      thinner = this.apart();
    }
    this.frames = thinner;
    this.bytes = thinner.reduce((sum, { bytes }) => sum + bytes.byteLength, 0);
  }

  /** Returns the new frames, and old ones that are a step apart. */
  private apart(): Kept[] {
    const old = this.frames.length - Math.min(WHOLE, this.frames.length >> 1);
    let last = -Infinity;
    return this.frames.filter(({ time }, index) => {
      const isKept = index >= old || time >= last + this.step;
      if (isKept) last = time;
      return isKept;
    });
  }

  clear(): void {
    this.frames = [];
    [this.bytes, this.step] = [0, FIRST_STEP];
  }

  /** First and last time that can be looked at, s. */
  get range(): [number, number] {
    return [this.frames[0]?.time ?? 0, this.frames.at(-1)?.time ?? 0];
  }

  /** The last frame that is not later. */
  at(time: number): Frame | null {
    const frame = this.frames.findLast((frame) => frame.time <= time) ?? this.frames[0];
    return frame ? read(frame.bytes) : null;
  }

  /** The time of the first frame after a time; the last frame's if there is none. */
  after(time: number): number {
    return (this.frames.find((frame) => frame.time > time) ?? this.frames.at(-1))?.time ?? time;
  }

  /** The time of the last frame before a time; the first frame's if there is none. */
  before(time: number): number {
    return (this.frames.findLast((frame) => frame.time < time) ?? this.frames[0])?.time ?? time;
  }

  /** About so many frames, evenly over all that is kept. */
  sample(count: number): Frame[] {
    const step = Math.max(1, Math.ceil(this.frames.length / count));
    return this.frames.filter((_, index) => index % step === 0).flatMap(({ bytes }) => read(bytes) ?? []);
  }
}

function read(bytes: ArrayBuffer): Frame | null {
  const message = readMessage(bytes);
  return message && 'frame' in message ? message.frame : null;
}
