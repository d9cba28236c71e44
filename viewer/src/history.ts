/** The frames of the last minute, so that one can look back while the world goes on. */

import { type Frame, readMessage } from './protocol/frame';

/** Frames that are kept: a minute of 30 a second. */
const KEPT = 1800;
/** Bytes that they may take together: fewer are kept of a world with many robots. */
const MOST_BYTES = 64 << 20;

export class History {
  private frames: { time: number; bytes: ArrayBuffer }[] = [];
  private bytes = 0;

  add(time: number, bytes: ArrayBuffer): void {
    const last = this.frames.at(-1)?.time ?? -Infinity;
    if (time === last) return;
    // A world that began anew.
    if (time < last) this.clear();
    this.frames.push({ time, bytes });
    this.bytes += bytes.byteLength;
    while (this.frames.length > KEPT || this.bytes > MOST_BYTES)
      this.bytes -= this.frames.shift()?.bytes.byteLength ?? 0;
  }

  clear(): void {
    this.frames = [];
    this.bytes = 0;
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
