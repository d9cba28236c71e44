/** Fields of MCAP records: little-endian numbers, and texts with their length before them. */

const decoder = new TextDecoder();

export class Bytes {
  private at = 0;
  private readonly view: DataView;

  constructor(private readonly bytes: Uint8Array) {
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  get left(): number {
    return this.bytes.length - this.at;
  }

  u8(): number {
    return this.view.getUint8(this.skip(1));
  }

  u16(): number {
    return this.view.getUint16(this.skip(2), true);
  }

  u32(): number {
    return this.view.getUint32(this.skip(4), true);
  }

  /** Exact up to 2^53: as ns 104 days. */
  u64(): number {
    const low = this.u32();
    return low + 2 ** 32 * this.u32();
  }

  take(count: number): Uint8Array {
    const from = this.skip(count);
    return this.bytes.subarray(from, from + count);
  }

  text(): string {
    return decoder.decode(this.take(this.u32()));
  }

  /** Texts by texts. */
  map(): Record<string, string> {
    const entries = new Bytes(this.take(this.u32()));
    const map: Record<string, string> = {};
    while (entries.left > 0) {
      const key = entries.text();
      map[key] = entries.text();
    }
    return map;
  }

  private skip(count: number): number {
    if (count > this.left) throw new Error('a record is too short');
    this.at += count;
    return this.at - count;
  }
}
