/**
 * A log of the server (docs/logs.md), opened in the browser: what was there at any time, and what was said. Only its index is
 * kept, and the parts that were read last.
 */

import type { Frame, Scan } from '../protocol/frame';
import type { Status, WireLine } from '../protocol/live';
import type { Pose, Scene, Solid } from '../protocol/scene';
import type { Reading } from '../protocol/sensors';
import { Chunks, lastMessage, messagesBetween } from './chunks';
import { type Chunk, type Contents, type Message, readContents } from './mcap';
import { readLeft, readLine, readLineOwner, readRanges, readReading, readState, readTransforms } from './messages';
import { LogObjects } from './objects';
import { robotState } from './robot';
import { Source } from './source';

export type LogRobots = Status['robots'];

/** Poses of the robots at one time, and their names. */
export interface RobotsMoment {
  frame: Frame;
  robots: LogRobots;
}

/** Poses of robots and objects at one time, and the spawned objects. */
export interface Moment extends RobotsMoment {
  /** Objects of the frame that the map does not have, by number. */
  spawned: Map<number, Solid>;
}

/** The newest format of logs that is read, as in crates/recorder/src/lib.rs. */
const FORMAT = 3;
/** Name of the metadata of a class, before the class's own name. */
const CLASS = 'class/';
/** Robots are recorded every 20 ms or at the first step after, which takes 20 ms at most; ns. */
const STATE_WINDOW = 50e6;
/** Lines that are given at once, the newest; more are more than a page shows. */
const MAX_LINES = 1000;

interface Slot {
  frame: string;
  state: number;
  transforms: number | undefined;
  /** Channels of readings. */
  readings: number[];
  /** Channels of the scans of level lasers, with the lasers' names. */
  scans: { name: string; channel: number }[];
}

export class LogFile {
  /** s */
  readonly start: number;
  /** s */
  readonly end: number;
  /** Reason why the rest of the file cannot be read; `null` for a whole log. */
  readonly damage: string | null;
  private readonly chunks: Chunks;
  private readonly slots: Slot[];
  private readonly objects: LogObjects;
  private readonly connections = new Map<number, number>();

  private constructor(
    source: Source,
    contents: Contents,
    /** Description of the run: seed, time step and options. */
    readonly run: Record<string, string>,
    readonly scene: Scene,
  ) {
    const last = contents.chunks.reduce((end, chunk) => Math.max(end, chunk.end), 0) / 1e9;
    this.start = numberOf(run.began) ?? 0;
    this.end = Math.max(numberOf(contents.metadata.get('end')?.seconds) ?? last, this.start);
    this.damage = contents.damage;
    this.chunks = new Chunks(source, contents, (chunk) => this.learn(chunk));
    this.slots = slotsOf(contents.topics);
    this.objects = new LogObjects(this.chunks, contents.topics, scene.map.objects);
  }

  /** Opens a log. `askScene` makes the scene that the page draws of the world that the log describes, in JSON. */
  static async open(file: Blob, askScene: (world: string) => Promise<Scene>): Promise<LogFile> {
    const source = new Source(file);
    const contents = await readContents(source);
    const run = contents.metadata.get('run');
    if (!run) throw new Error('no log of usarsim: expected the metadata `run`');
    const format = numberOf(run.format) ?? 1;
    if (!(format >= 1 && format <= FORMAT)) {
      throw new Error(`it is of format ${run.format}, expected 1 to ${FORMAT}; a newer usarsim may read it`);
    }
    const scene = await askScene(worldOf(contents.metadata));
    // The text has several MB where a map has meshes.
    const { scene: _, classes: __, ...rest } = run;
    const numbers = { seed: numberOf(run.seed) ?? 0, time_step: numberOf(run.time_step) ?? 0 };
    return new LogFile(source, contents, rest, { ...scene, ...numbers });
  }

  /** Returns the poses of robots and objects at a time, s. */
  async frameAt(time: number): Promise<Frame> {
    return (await this.momentAt(time)).frame;
  }

  /** Returns a frame with its robots' names and spawned objects. */
  async momentAt(time: number): Promise<Moment> {
    const [{ frame, robots }, { objects, spawned }] = await Promise.all([
      this.robotsAt(time),
      this.objects.at(nanoseconds(time)),
    ]);
    return { frame: { ...frame, objects }, robots, spawned };
  }

  /**
   * Returns the poses and names of robots, without objects. Nothing is between two states of a robot, which are 20 ms apart:
   * the earlier one counts.
   */
  async robotsAt(time: number): Promise<RobotsMoment> {
    const [until, chunks] = await this.chunksBetween(time - STATE_WINDOW / 1e9, time);
    const gone = this.leftBy(chunks, until);
    const found = this.slots.flatMap((slot) => {
      const message = lastOf(chunks, slot.state, until);
      const state = message && readState(message.data);
      const robotClass = state && this.scene.classes[state.class];
      if (!state || !robotClass || gone.has(state.robot)) return [];
      const moved = lastOf(chunks, slot.transforms, until);
      const transforms = moved ? readTransforms(moved.data) : new Map<string, Pose>();
      return [{ state, robot: robotState(state, robotClass, slot.frame, transforms) }];
    });
    found.sort((a, b) => a.robot.id - b.robot.id);
    const robots = found.map(({ state: { robot: id, class: robotClass, name } }) => {
      return { id, class: robotClass, name, connection: this.connections.get(id) ?? null, battery: null };
    });
    return { frame: { time, robots: found.map(({ robot }) => robot), objects: [], pulls: [] }, robots };
  }

  /** Returns the lines after one time up to another, s; the newest if there are too many. */
  async linesBetween(after: number, until: number): Promise<WireLine[]> {
    const [to, chunks] = await this.chunksBetween(after, until);
    const of = (chunk: Chunk, direction: 'in' | 'out') => {
      const messages = messagesBetween([chunk], this.chunks.channel(`/wire/${direction}`), nanoseconds(after), to);
      return messages.map((message) => ({ message, direction }));
    };
    const lines = chunks.flatMap((chunk) => {
      return [...of(chunk, 'in'), ...of(chunk, 'out')].sort((a, b) => a.message.order - b.message.order);
    });
    return lines.slice(-MAX_LINES).map(({ message, direction }) => {
      const { connection, robot, line } = readLine(message.data);
      return { time: message.time / 1e9, direction, connection, robot, text: line };
    });
  }

  /** The newest scan of each laser and sonar from after one time up to another, s. */
  async scansBetween(after: number, until: number): Promise<Scan[]> {
    const [to, chunks] = await this.chunksBetween(after, until);
    const from = nanoseconds(after);
    const robots = this.slots.flatMap((slot) => {
      const state = lastOf(chunks, slot.state, to);
      if (!state) return [];
      const { robot, class: robotClass } = readState(state.data);
      return [{ robot, slot, sensors: this.scene.classes[robotClass]?.sensors ?? [] }];
    });
    const scans = robots.flatMap(({ robot, slot, sensors }) => {
      const ranges = new Map<string, number[]>();
      for (const { name, channel } of slot.scans) {
        const message = lastOf(chunks, channel, to);
        if (message && message.time > from) ranges.set(name, readRanges(message.data));
      }
      // Foxglove has no scans of sonars, nor of lasers that are not level.
      for (const { sensor, quantities } of newestReadings(slot, chunks, from, to)) {
        const name = sensors[sensor]?.name;
        const measured = quantities.find(({ name }) => name === 'ranges' || name === 'range');
        if (name !== undefined && measured && !ranges.has(name)) ranges.set(name, measured.values);
      }
      return sensors.map(({ name, max_range }, sensor) => {
        const parts = ranges.get(name)?.map((range) => Math.min(1, Math.max(0, range / (max_range ?? 1))));
        return max_range && parts ? { robot, sensor, ranges: parts } : null;
      });
    });
    return scans.filter((scan) => scan !== null);
  }

  /** The newest reading of each sensor from after one time up to another, s. */
  async readingsBetween(after: number, until: number): Promise<Reading[]> {
    const [to, chunks] = await this.chunksBetween(after, until);
    return this.slots.flatMap((slot) => newestReadings(slot, chunks, nanoseconds(after), to));
  }

  private async chunksBetween(after: number, until: number): Promise<[number, Chunk[]]> {
    const to = nanoseconds(until);
    return [to, await this.chunks.between(nanoseconds(after), to)];
  }

  /** Robots that have left; before `/robots/left` the end of their connection said so. */
  private leftBy(chunks: Chunk[], until: number): Set<number> {
    const of = (topic: string) => messagesBetween(chunks, this.chunks.channel(topic), -1, until);
    const left = of('/robots/left').map(({ data }) => readLeft(data));
    const closed = of('/wire/closed').flatMap(({ data }) => readLineOwner(data).robot ?? []);
    return new Set([...left, ...closed]);
  }

  /** Learns the connection of each robot. */
  private learn(chunk: Chunk): void {
    for (const topic of ['/wire/in', '/wire/out']) {
      for (const { data } of chunk.messages.get(this.chunks.channel(topic) ?? -1) ?? []) {
        const { connection, robot } = readLineOwner(data);
        if (robot !== null) this.connections.set(robot, connection);
      }
    }
  }
}

/** Returns the world that a log describes, as JSON. Its texts are JSON already, and too long to be parsed here. */
function worldOf(metadata: Contents['metadata']): string {
  const { scene, classes = '[]' } = metadata.get('run') ?? {};
  if (scene === undefined) throw new Error('no `scene` in its metadata');
  const used = [...metadata].flatMap(([name, { definition }]) => {
    const isClass = name.startsWith(CLASS) && definition !== undefined;
    return isClass ? [`${JSON.stringify(name.slice(CLASS.length))}:${definition}`] : [];
  });
  return `{"scene":${scene},"names":${classes},"classes":{${used.join()}}}`;
}

/** The topics of robots by their slots: the numbers in topics, which are given back. */
function slotsOf(topics: Map<number, string>): Slot[] {
  const slots = new Map<string, Map<string, number>>();
  for (const [channel, topic] of topics) {
    const [, slot, name] = /^\/robot\/(\d+)\/(.+)$/.exec(topic) ?? [];
    if (slot === undefined || name === undefined) continue;
    slots.set(slot, (slots.get(slot) ?? new Map<string, number>()).set(name, channel));
  }
  return [...slots].flatMap(([slot, channels]) => {
    const state = channels.get('state');
    const ofSensors = [...channels].filter(([name]) => name.startsWith('sensor/'));
    // A sensor may be called `reading` itself.
    const readings = ofSensors.flatMap(([name, channel]) => (/^sensor\/.+\/reading$/.test(name) ? [channel] : []));
    const ofScans = ofSensors.filter(([name]) => !/^sensor\/.+\/(reading|image|picture)$/.test(name));
    const scans = ofScans.map(([name, channel]) => ({ name: name.slice('sensor/'.length), channel }));
    const transforms = channels.get('tf');
    return state === undefined ? [] : [{ frame: `robot/${slot}`, state, transforms, readings, scans }];
  });
}

/** The newest reading of each sensor of a slot after one time up to another, ns. */
function newestReadings({ readings }: Slot, chunks: Chunk[], from: number, to: number): Reading[] {
  return readings.flatMap((channel) => {
    const message = lastOf(chunks, channel, to);
    return message && message.time > from ? [{ ...readReading(message.data), time: message.time / 1e9 }] : [];
  });
}

/** The last message of a channel in chunks up to a time. */
function lastOf(chunks: Chunk[], channel: number | undefined, until: number): Message | null {
  for (let at = chunks.length - 1; at >= 0; at--) {
    const found = lastMessage(chunks[at]!, channel, until);
    if (found) return found;
  }
  return null;
}

function nanoseconds(seconds: number): number {
  return Math.round(seconds * 1e9);
}

function numberOf(text: string | undefined): number | null {
  const number = Number.parseFloat(text ?? '');
  return Number.isFinite(number) ? number : null;
}
