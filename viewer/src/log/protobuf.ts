/** Fields of a log's messages, by pbf. It reads beyond the end of a message without an error, so ends are checked here. */

import { PbfReader } from 'pbf';

/** Kind of a field with a length before its bytes. */
const WITH_LENGTH = 2;

const decoder = new TextDecoder();

export class Fields {
  private readonly pbf: PbfReader;

  constructor(bytes: Uint8Array) {
    this.pbf = new PbfReader(bytes);
  }

  /** Exact up to 2^53. */
  varint(): number {
    return this.checked(this.pbf.readVarint());
  }

  message(): Uint8Array {
    const length = this.varint();
    const from = this.pbf.pos;
    this.pbf.pos += length;
    return this.checked(this.pbf.buf.subarray(from, from + length));
  }

  text(): string {
    return decoder.decode(this.message());
  }

  double(): number {
    return this.pbf.readDouble();
  }

  /** Numbers of a repeated field, one or all. */
  doubles(): number[] {
    if (this.pbf.type !== WITH_LENGTH) return [this.double()];
    const packed = this.message();
    const numbers = new Fields(packed);
    return Array.from({ length: Math.floor(packed.length / 8) }, () => numbers.double());
  }

  /** Reads each field by the function of its number; others are skipped. */
  each(read: Record<number, (fields: Fields) => void>): void {
    for (let field = this.pbf.nextField(); field; field = this.pbf.nextField()) read[field]?.(this);
    this.checked(undefined);
  }

  private checked<T>(value: T): T {
    if (this.pbf.pos > this.pbf.length) throw new Error('a message is too short');
    return value;
  }
}

/** Reads each field of a message by the function of its number; others are skipped. */
export function eachField(bytes: Uint8Array, read: Record<number, (fields: Fields) => void>): void {
  new Fields(bytes).each(read);
}
