/**
 * MCAP files as the server writes them (mcap.dev/spec): in chunks, compressed with LZ4. What a file holds is read from its index,
 * or, when it was cut off and has none, from the heads of its records; a chunk is read when it is asked for.
 *
 * Times are whole ns.
 *
 * The library for it, @mcap/core (2.2.2), refuses a file that is not indexed, as one that was cut off, and reads and decompresses a
 * chunk again for each question; a page that plays a log asks thirty times a second.
 */

import { Bytes } from './bytes';
import { crc32 } from './crc32';
import { readLz4Frame } from './lz4';
import type { Source } from './source';

const MAGIC = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];
/** Opcode and length before each record. */
const HEAD_BYTES = 9;
const FOOTER_BYTES = HEAD_BYTES + 20;
/** Largest record, and largest chunk when it is decompressed, as in crates/recorder/src/records.rs. */
const MAX_RECORD_BYTES = 256 << 20;
/** LZ4 makes at most so many bytes of one. */
const MAX_EXPANSION = 255;
/** Memory of a message beside its data, bytes, approximately. */
const MESSAGE_BYTES = 200;
/** Size of a chunk's head before its data, bytes; `lz4` is the longest name of a compression. */
const CHUNK_HEAD_BYTES = 8 + 8 + 8 + 4 + 4 + 3 + 8;

const Op = {
  footer: 0x02,
  channel: 0x04,
  message: 0x05,
  chunk: 0x06,
  messageIndex: 0x07,
  chunkIndex: 0x08,
  metadata: 0x0c,
  metadataIndex: 0x0d,
  dataEnd: 0x0f,
};

export interface ChunkPlace {
  start: number;
  end: number;
  /** Position of the whole record in the file. */
  offset: number;
  length: number;
  /** Channels of its messages. */
  channels: number[];
}

export interface Contents {
  /** Topics of channels. */
  topics: Map<number, string>;
  metadata: Map<string, Record<string, string>>;
  /** Chunks by time. */
  chunks: ChunkPlace[];
  /** Reason why the rest of the file cannot be read. */
  damage: string | null;
}

export interface Message {
  time: number;
  /** Place of the message in the chunk. */
  order: number;
  data: Uint8Array;
}

export interface Chunk {
  /** Topics of channels that begin in the chunk. */
  topics: Map<number, string>;
  /** Messages by channel, in the order of the file. */
  messages: Map<number, Message[]>;
  /** Bytes in memory. */
  bytes: number;
}

export async function readContents(source: Source): Promise<Contents> {
  const magic = await source.read(0, MAGIC.length);
  if (magic.length < MAGIC.length || MAGIC.some((byte, at) => magic[at] !== byte)) {
    throw new Error('not an MCAP file: expected a log of usarsim, as run.mcap');
  }
  // An index that is not right is no worse than none.
  const contents = (await readIndex(source).catch(() => null)) ?? (await readHeads(source));
  contents.chunks.sort((a, b) => a.start - b.start);
  return contents;
}

/** Reads the index at the end; `null` for a file without one. */
async function readIndex(source: Source): Promise<Contents | null> {
  const end = source.size - MAGIC.length - FOOTER_BYTES;
  if (end < MAGIC.length) return null;
  const tail = await source.read(end, FOOTER_BYTES + MAGIC.length);
  const footer = new Bytes(tail);
  if (footer.u8() !== Op.footer || MAGIC.some((byte, at) => tail[FOOTER_BYTES + at] !== byte)) return null;
  footer.u64();
  const start = footer.u64();
  if (start === 0 || start > end || end - start > MAX_RECORD_BYTES) return null;
  const contents: Contents = { topics: new Map(), metadata: new Map(), chunks: [], damage: null };
  const metadata: { offset: number; length: number }[] = [];
  const within = (place: { offset: number; length: number }) => {
    if (place.offset + place.length > start) throw new Error('its index is damaged');
    return place;
  };
  eachRecord(await source.read(start, end - start), (opcode, fields) => {
    if (opcode === Op.channel) readChannel(fields, contents.topics);
    if (opcode === Op.metadataIndex) metadata.push(within({ offset: fields.u64(), length: fields.u64() }));
    if (opcode === Op.chunkIndex) {
      const [start, end, offset, length] = [fields.u64(), fields.u64(), fields.u64(), fields.u64()];
      const offsets = new Bytes(fields.take(fields.u32()));
      const channels: number[] = [];
      for (; offsets.left > 0; offsets.u64()) channels.push(offsets.u16());
      contents.chunks.push({ start, end, channels, ...within({ offset, length }) });
    }
  });
  for (const { offset, length } of metadata) {
    eachRecord(await source.read(offset, length), (_, fields) => contents.metadata.set(fields.text(), fields.map()));
  }
  return contents;
}

/** Reads the records before the first damage, without the contents of chunks. */
async function readHeads(source: Source): Promise<Contents> {
  const contents: Contents = { topics: new Map(), metadata: new Map(), chunks: [], damage: 'it is cut off' };
  let chunk: ChunkPlace | null = null;
  for (let offset = MAGIC.length; offset + HEAD_BYTES <= source.size;) {
    const head = new Bytes(await source.ahead(offset, HEAD_BYTES));
    const [opcode, length] = [head.u8(), head.u64()];
    const end = offset + HEAD_BYTES + length;
    if (opcode === Op.dataEnd) {
      contents.damage = 'its index is damaged';
      break;
    }
    if (end > source.size || opcode === 0) break;
    const fields = async (most: number) =>
      new Bytes(await source.ahead(offset + HEAD_BYTES, Math.min(length, most, MAX_RECORD_BYTES)));
    if (opcode === Op.channel) readChannel(await fields(length), contents.topics);
    if (opcode === Op.metadata) {
      const entry = await fields(length);
      contents.metadata.set(entry.text(), entry.map());
    }
    if (opcode === Op.chunk) {
      const entry = await fields(CHUNK_HEAD_BYTES);
      chunk = { start: entry.u64(), end: entry.u64(), offset, length: HEAD_BYTES + length, channels: [] };
      contents.chunks.push(chunk);
    }
    if (opcode === Op.messageIndex && chunk && length > 6) chunk.channels.push((await fields(2)).u16());
    offset = end;
  }
  source.forget();
  const last = contents.chunks.at(-1);
  for (const chunk of contents.chunks) {
    // Topics stand in the chunk in which they begin; the last chunk's own index may be cut off.
    const isNew = chunk.channels.some((channel) => !contents.topics.has(channel));
    if (!isNew && chunk !== last) continue;
    const { topics, messages } = await readChunk(source, chunk);
    topics.forEach((topic, channel) => contents.topics.set(channel, topic));
    chunk.channels = [...messages.keys()];
  }
  return contents;
}

/** The messages of a chunk, if its checksum is right. */
export async function readChunk(source: Source, place: ChunkPlace): Promise<Chunk> {
  const damaged = (reason: string) => new Error(`the log is damaged at byte ${place.offset}: ${reason}`);
  if (place.length > MAX_RECORD_BYTES) throw damaged(`a chunk of ${place.length} bytes`);
  const record = new Bytes(await source.read(place.offset, place.length));
  if (record.left < HEAD_BYTES || record.u8() !== Op.chunk) throw damaged('expected a chunk');
  for (const _ of ['length', 'start', 'end']) record.u64();
  const [size, checksum, compression] = [record.u64(), record.u32(), record.text()];
  const data = record.take(record.u64());
  if (size > Math.min(MAX_RECORD_BYTES, data.length * MAX_EXPANSION)) throw damaged(`a chunk of ${size} bytes`);
  if (compression !== 'lz4' && compression !== '') throw damaged(`compression ${compression}: expected lz4 or none`);
  try {
    const bytes = compression === 'lz4' ? readLz4Frame(data, size) : data;
    // 0 says that there is none.
    if (checksum !== 0 && crc32(bytes) !== checksum) throw new Error('a wrong checksum');
    return splitChunk(bytes);
  } catch (reason) {
    throw damaged(reason instanceof Error ? reason.message : String(reason));
  }
}

function splitChunk(bytes: Uint8Array): Chunk {
  const chunk: Chunk = { topics: new Map(), messages: new Map(), bytes: 0 };
  let order = 0;
  eachRecord(bytes, (opcode, fields) => {
    if (opcode === Op.channel) readChannel(fields, chunk.topics);
    if (opcode !== Op.message) return;
    const channel = fields.u16();
    fields.u32(); // sequence
    const time = fields.u64();
    fields.u64(); // when it was published
    const message = { time, order: order++, data: fields.take(fields.left) };
    const messages = chunk.messages.get(channel);
    if (messages) messages.push(message);
    else chunk.messages.set(channel, [message]);
  });
  return { ...chunk, bytes: bytes.length + MESSAGE_BYTES * order };
}

function eachRecord(bytes: Uint8Array, take: (opcode: number, fields: Bytes) => void): void {
  const records = new Bytes(bytes);
  while (records.left > 0) {
    const opcode = records.u8();
    take(opcode, new Bytes(records.take(records.u64())));
  }
}

function readChannel(fields: Bytes, topics: Map<number, string>): void {
  const channel = fields.u16();
  fields.u16(); // schema
  topics.set(channel, fields.text());
}
