/** A file of which parts are read. */

/** Bytes read at once where a file is read from its beginning to its end. */
const BLOCK = 4 << 20;

export class Source {
  private block: Uint8Array = new Uint8Array(0);
  private blockStart = 0;

  constructor(private readonly file: Blob) {}

  get size(): number {
    return this.file.size;
  }

  async read(offset: number, length: number): Promise<Uint8Array> {
    try {
      return new Uint8Array(await this.file.slice(offset, offset + length).arrayBuffer());
    } catch (reason) {
      // What a browser says then is only that it could not be read.
      throw new Error(`the file cannot be read, or has changed since it was opened: ${String(reason)}`);
    }
  }

  /** Reads small parts one after the other. Bytes that are there already are given at once. */
  ahead(offset: number, length: number): Uint8Array | Promise<Uint8Array> {
    const from = offset - this.blockStart;
    if (from >= 0 && from + length <= this.block.length) return this.block.subarray(from, from + length);
    return this.read(offset, Math.max(BLOCK, length)).then((block) => {
      [this.block, this.blockStart] = [block, offset];
      return block.subarray(0, length);
    });
  }

  /** Lets go of what was read ahead. */
  forget(): void {
    this.block = new Uint8Array(0);
  }
}
