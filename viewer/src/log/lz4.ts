/** The LZ4 frame format, version 1.6.4 (github.com/lz4/lz4, doc/lz4_Frame_format.md and lz4_Block_format.md), read. */

import { Bytes } from './bytes';

const MAGIC = 0x184d2204;
/** Flags of the parts beside the blocks. */
const [DICTIONARY, CONTENT_SIZE, BLOCK_CHECKSUM] = [0x01, 0x08, 0x10];
/** A block that is not compressed. */
const PLAIN = 0x80000000;
/** Shortest match. */
const LEAST_MATCH = 4;

/** Decompresses a frame that has `size` bytes. Its checksums are not looked at: an MCAP chunk has one of its own. */
export function readLz4Frame(frame: Uint8Array, size: number): Uint8Array {
  const fields = new Bytes(frame);
  if (fields.u32() !== MAGIC) throw new Error('LZ4: no frame');
  const flags = fields.u8();
  fields.u8(); // largest block
  if (flags >> 6 !== 1 || flags & DICTIONARY) throw new Error(`LZ4: flags ${flags}: expected version 1, no dictionary`);
  if (flags & CONTENT_SIZE) fields.u64();
  fields.u8(); // checksum of this header
  const target = new Uint8Array(size);
  let end = 0;
  for (let length = fields.u32(); length !== 0; length = fields.u32()) {
    const block = fields.take(length & ~PLAIN);
    if (length & PLAIN) {
      if (block.length > size - end) throw new Error(`LZ4: more than ${size} bytes`);
      target.set(block, end);
      end += block.length;
    } else {
      end = readBlock(block, target, end);
    }
    if (flags & BLOCK_CHECKSUM) fields.u32();
  }
  if (end !== size) throw new Error(`LZ4: ${end} bytes: expected ${size}`);
  return target;
}

/** Appends what a block holds to the first `end` bytes of the target, to which it may refer; the new end. */
function readBlock(block: Uint8Array, target: Uint8Array, end: number): number {
  let at = 0;
  /** A length of which 15 says that more follows, in bytes of which 255 says the same. */
  const lengthFrom = (nibble: number) => {
    let length = nibble;
    for (let byte = nibble === 15 ? 255 : 0; byte === 255; length += byte) byte = block[at++] ?? 0;
    return length;
  };
  while (at < block.length) {
    const token = block[at++]!;
    const literals = lengthFrom(token >> 4);
    if (literals > block.length - at || literals > target.length - end) throw new Error('LZ4: literals too long');
    for (const last = at + literals; at < last;) target[end++] = block[at++]!;
    if (at === block.length) break; // the last sequence has no match
    const offset = (block[at] ?? 0) | ((block[at + 1] ?? 0) << 8);
    at += 2;
    const length = LEAST_MATCH + lengthFrom(token & 15);
    if (offset === 0 || offset > end || length > target.length - end) throw new Error('LZ4: a match out of range');
    // Byte by byte: a match may overlap with what it makes.
    for (const last = end + length; end < last; end++) target[end] = target[end - offset]!;
  }
  return end;
}
