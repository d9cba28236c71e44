/** Protobuf's wire format (protobuf.dev/programming-guides/encoding), as far as a log's messages need it. */

const decoder = new TextDecoder();

export class Fields {
  /** Number of the field that was found. */
  field = 0;
  private kind = 0;
  private at = 0;
  private readonly view: DataView;

  constructor(private readonly bytes: Uint8Array) {
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  /** Finds the next field, of which the value is to be read, or skipped. */
  next(): boolean {
    if (this.at >= this.bytes.length) return false;
    const tag = this.varint();
    [this.field, this.kind] = [Math.floor(tag / 8), tag % 8];
    return true;
  }

  /** Exact up to 2^53. */
  varint(): number {
    let value = 0;
    for (let factor = 1; factor < 2 ** 70; factor *= 128) {
      const byte = this.view.getUint8(this.take(1));
      value += (byte & 127) * factor;
      if (byte < 128) return value;
    }
    throw new Error('a message with a number of more than 10 bytes');
  }

  double(): number {
    return this.view.getFloat64(this.take(8), true);
  }

  message(): Uint8Array {
    const length = this.varint();
    const from = this.take(length);
    return this.bytes.subarray(from, from + length);
  }

  text(): string {
    return decoder.decode(this.message());
  }

  /** Numbers of a repeated field, one or all. */
  doubles(): number[] {
    if (this.kind === 1) return [this.double()];
    const packed = new Fields(this.message());
    return Array.from({ length: Math.floor(packed.bytes.length / 8) }, () => packed.double());
  }

  skip(): void {
    if (this.kind === 0) this.varint();
    else if (this.kind === 1) this.take(8);
    else if (this.kind === 2) this.message();
    else if (this.kind === 5) this.take(4);
    else throw new Error(`a message with a field of kind ${this.kind}`);
  }

  private take(count: number): number {
    if (count > this.bytes.length - this.at) throw new Error('a message is too short');
    this.at += count;
    return this.at - count;
  }
}

/** Reads each field by the function of its number; others are skipped. */
export function eachField(bytes: Uint8Array, read: Record<number, (fields: Fields) => void>): void {
  const fields = new Fields(bytes);
  while (fields.next()) (read[fields.field] ?? ((it) => it.skip()))(fields);
}
