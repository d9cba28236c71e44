/**
 * The movable objects of a log. A world controller creates and removes them, so that at a time there are those of the map and
 * those that came, without those that were removed. The chunks that say so are found in the index and read once.
 */

import type { ObjectState } from '../protocol/frame';
import type { Pose, Shape, Solid, Vector } from '../protocol/scene';
import { type Chunks, messagesBetween } from './chunks';
import { readLeft, readObject, readSpawned } from './messages';

/** A solid as `/objects/spawned` has it. */
interface Definition {
  solid: {
    name: string;
    shape: Shape;
    position: Vector;
    /** Roll, pitch, yaw, rad. */
    rotation: Vector;
    material: { name: string; friction: number; colour: Solid['colour'] };
  };
}

export class LogObjects {
  /** Channels of states. A channel is of one object after the other. */
  private readonly places: number[];
  /** Chunks that say which objects came or were removed, and how many of them have been read. */
  private readonly telling: number[];
  private told = 0;
  private reading = Promise.resolve();
  /** Spawned objects by number, with the time of their arrival, ns. */
  private readonly spawned = new Map<number, { time: number; solid: Solid }>();
  /** Times at which objects were removed, ns, by number. */
  private readonly removed = new Map<number, number>();

  constructor(
    private readonly chunks: Chunks,
    topics: Map<number, string>,
    private readonly ofMap: Solid[],
  ) {
    const channels = (pattern: RegExp) =>
      [...topics].flatMap(([channel, topic]) => (pattern.test(topic) ? channel : []));
    this.places = channels(/^\/map\/object\/\d+$/);
    this.telling = chunks.holdingAny(channels(/^\/objects\/(spawned|removed)$/));
  }

  /** Returns the poses of objects at a time, ns, and the objects that the map does not have. */
  async at(until: number): Promise<{ objects: ObjectState[]; spawned: Map<number, Solid> }> {
    const [poses] = await Promise.all([this.posesAt(until), this.listen(until)]);
    const isThere = (number: number) => (this.removed.get(number) ?? Infinity) > until;
    const came = [...this.spawned].filter(([number, { time }]) => time <= until && isThere(number));
    const spawned = new Map(came.map(([number, { solid }]) => [number, solid]));
    const solids = [...[...this.ofMap.entries()].filter(([number]) => isThere(number)), ...spawned];
    const objects = solids.map(([number, { pose }]) => ({ number, pose: poses.get(number) ?? pose }));
    return { objects, spawned };
  }

  /** The last poses until a time, by the objects' numbers; also of objects that are gone. */
  private async posesAt(until: number): Promise<Map<number, Pose>> {
    const messages = await Promise.all(this.places.map((channel) => this.chunks.lastOf(channel, until)));
    const states = messages.flatMap((message) => (message ? readObject(message.data) : []));
    return new Map(states.map(({ number, pose }) => [number, pose]));
  }

  /** Hears which objects came and were removed until a time: one chunk after the other, so that few are in memory. */
  private listen(until: number): Promise<void> {
    const last = this.chunks.lastUntil(until);
    this.reading = this.reading.then(async () => {
      while ((this.telling[this.told] ?? Infinity) <= last) {
        // One that is damaged is skipped: who looks at its time is told, and the rest can be looked at.
        await this.hear(this.telling[this.told++]!).catch(() => {});
      }
    });
    return this.reading;
  }

  private async hear(place: number): Promise<void> {
    const chunk = await this.chunks.read(place);
    const messages = (topic: string) => messagesBetween([chunk], this.chunks.channel(topic), -1, Infinity);
    for (const { time, data } of messages('/objects/spawned')) {
      const { number, definition } = readSpawned(data);
      const solid = solidOf(definition);
      if (solid) this.spawned.set(number, { time, solid });
    }
    for (const { time, data } of messages('/objects/removed')) this.removed.set(readLeft(data), time);
  }
}

/** A definition as a page draws it; null for a text that is none. */
function solidOf(definition: string): Solid | null {
  try {
    const { name, shape, position, rotation, material } = (JSON.parse(definition) as Definition).solid;
    const { name: materialName, friction, colour } = material;
    const pose: Pose = [...position, ...quaternion(rotation)];
    const isSound = [...pose, ...colour].every(Number.isFinite) && isShape(shape);
    return isSound ? { name, shape, pose, material: materialName, colour, friction } : null;
  } catch {
    return null;
  }
}

function isShape(shape: Shape): boolean {
  if (shape === 'HalfSpace') return true;
  return ['Box', 'Cylinder', 'Ball', 'Mesh', 'Hull'].some((kind) => kind in shape);
}

/** The turn about x by roll, then about y by pitch, then about z by yaw, of fixed axes. */
function quaternion([roll, pitch, yaw]: Vector): [number, number, number, number] {
  const [cx, cy, cz] = [Math.cos(roll / 2), Math.cos(pitch / 2), Math.cos(yaw / 2)];
  const [sx, sy, sz] = [Math.sin(roll / 2), Math.sin(pitch / 2), Math.sin(yaw / 2)];
  return [
    sx * cy * cz - cx * sy * sz,
    cx * sy * cz + sx * cy * sz,
    cx * cy * sz - sx * sy * cz,
    cx * cy * cz + sx * sy * sz,
  ];
}
