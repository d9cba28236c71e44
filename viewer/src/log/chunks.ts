/** The chunks of a log: which of them are of a time, and those that were read last. */

import { type Chunk, type Contents, type Message, readChunk } from './mcap';
import type { Source } from './source';

/** Memory for chunks that were read, bytes. A second of ten youBots takes 2 MB. */
const MAX_CACHED = 64 << 20;

export class Chunks {
  /** The one that was used last is the last. */
  private readonly cached = new Map<number, { chunk: Promise<Chunk>; bytes: number }>();
  private readonly channels: Map<string, number>;
  /** Places in `contents.chunks` by channel, where they are asked for. */
  private readonly holding = new Map<number, number[]>();
  /** Last result of `lastOf` by channel, and the time before which it holds. */
  private readonly found = new Map<number, { message: Message; next: number }>();

  constructor(
    private readonly source: Source,
    private readonly contents: Contents,
    /** Callback for each chunk that is read. */
    private readonly came: (chunk: Chunk) => void,
  ) {
    this.channels = new Map([...contents.topics].map(([channel, topic]) => [topic, channel]));
  }

  channel(topic: string): number | undefined {
    return this.channels.get(topic);
  }

  /** The chunks that have times from after one up to another, ns; with the one before, where `from` is in a gap. */
  between(from: number, to: number): Promise<Chunk[]> {
    const { chunks } = this.contents;
    const last = this.lastUntil(to);
    let first = last;
    while (first > 0 && chunks[first]!.start > from) first--;
    const numbers = Array.from({ length: last < 0 ? 0 : last - first + 1 }, (_, index) => first + index);
    return Promise.all(numbers.map((number) => this.read(number)));
  }

  /** The last message of a channel up to a time, however long ago. */
  async lastOf(channel: number, until: number): Promise<Message | null> {
    const known = this.found.get(channel);
    if (known && known.message.time <= until && until < known.next) return known.message;
    const holding = this.holdingOf(channel);
    const last = this.lastUntil(until);
    for (let at = firstAfter(holding, last, (number) => number) - 1; at >= 0; at--) {
      const messages = (await this.read(holding[at]!)).messages.get(channel) ?? [];
      const place = firstAfter(messages, until, ({ time }) => time);
      const found = messages[place - 1];
      if (!found) continue;
      // Its data is a part of the chunk, which is not to stay in memory for it.
      const message = { ...found, data: found.data.slice() };
      const following = this.contents.chunks[holding[at + 1] ?? -1];
      this.found.set(channel, { message, next: messages[place]?.time ?? following?.start ?? Infinity });
      return message;
    }
    return null;
  }

  /** The places of chunks that hold any of some channels, by time. */
  holdingAny(channels: number[]): number[] {
    return [...new Set(channels.flatMap((channel) => this.holdingOf(channel)))].sort((a, b) => a - b);
  }

  /** The place of the last chunk that begins by then; -1 where there is none. */
  lastUntil(time: number): number {
    return firstAfter(this.contents.chunks, time, ({ start }) => start) - 1;
  }

  private holdingOf(channel: number): number[] {
    let holding = this.holding.get(channel);
    if (!holding) {
      holding = [...this.contents.chunks.entries()].flatMap(([at, it]) => (it.channels.includes(channel) ? [at] : []));
      this.holding.set(channel, holding);
    }
    return holding;
  }

  /** The chunk at a place. */
  read(number: number): Promise<Chunk> {
    const entry = this.cached.get(number) ?? { chunk: this.load(number), bytes: 0 };
    this.cached.delete(number);
    this.cached.set(number, entry);
    return entry.chunk;
  }

  private async load(number: number): Promise<Chunk> {
    try {
      const chunk = await readChunk(this.source, this.contents.chunks[number]!);
      this.came(chunk);
      const entry = this.cached.get(number);
      if (entry) entry.bytes = chunk.bytes;
      this.shrink();
      return chunk;
    } catch (reason) {
      this.cached.delete(number);
      throw reason;
    }
  }

  private shrink(): void {
    let bytes = [...this.cached.values()].reduce((sum, entry) => sum + entry.bytes, 0);
    for (const [number, entry] of this.cached) {
      // One that is being read has no size yet.
      if (bytes <= MAX_CACHED || entry.bytes === 0) return;
      this.cached.delete(number);
      bytes -= entry.bytes;
    }
  }
}

/** The last message of a channel in a chunk up to a time. */
export function lastMessage(chunk: Chunk, channel: number | undefined, until: number): Message | null {
  const messages = channel === undefined ? undefined : chunk.messages.get(channel);
  return messages?.[firstAfter(messages, until, ({ time }) => time) - 1] ?? null;
}

/** The messages of a channel in chunks with times from after one up to another. */
export function messagesBetween(chunks: Chunk[], channel: number | undefined, after: number, until: number): Message[] {
  if (channel === undefined) return [];
  return chunks.flatMap((chunk) => {
    const messages = chunk.messages.get(channel) ?? [];
    const place = (limit: number) => firstAfter(messages, limit, ({ time }) => time);
    return messages.slice(place(after), place(until));
  });
}

/** The place of the first item beyond a limit in a list that ascends. */
function firstAfter<T>(items: T[], limit: number, value: (item: T) => number): number {
  let [from, to] = [0, items.length];
  while (from < to) {
    const middle = (from + to) >> 1;
    if (value(items[middle]!) > limit) to = middle;
    else from = middle + 1;
  }
  return from;
}
