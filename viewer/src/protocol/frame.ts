/** The binary messages of `/live`; their layout is in crates/gamebots-server/src/live/frame.rs. */

import type { Pose, Vector } from './scene';

export interface WheelState {
  /** rad */
  angle: number;
  /** rad/s */
  speed: number;
  /** rad/s */
  target: number;
  /** rad, about the rollers' own axes */
  rollers: number[];
}

export interface RobotState {
  id: number;
  pose: Pose;
  /** m/s along the robot's own axes */
  linear: Vector;
  /** rad/s about the robot's own axes */
  angular: Vector;
  wheels: WheelState[];
  /** the links that are no wheels, in the robot frame */
  links: Pose[];
  /** those that go to positions: rad and rad/s, or m and m/s */
  joints: { position: number; speed: number }[];
  contacts: { point: Vector; /** N */ force: Vector }[];
}

/** Where a movable object is. */
export interface ObjectState {
  /** the map's objects come first, in its order */
  number: number;
  pose: Pose;
}

export interface Frame {
  /** simulated s */
  time: number;
  robots: RobotState[];
  /** all that are in the world; an object of the map that is not here was removed */
  objects: ObjectState[];
}

export interface Scan {
  robot: number;
  sensor: number;
  /** parts of the sensor's range */
  ranges: number[];
}

/** What a camera saw. */
export interface Picture {
  robot: number;
  sensor: number;
  /** simulated s */
  time: number;
  /** a PNG file */
  png: Uint8Array<ArrayBuffer>;
}

class Reader {
  private at = 0;
  constructor(private readonly view: DataView<ArrayBuffer>) {}
  u8(): number {
    return this.view.getUint8(this.at++);
  }
  u16(): number {
    this.at += 2;
    return this.view.getUint16(this.at - 2, true);
  }
  i16(): number {
    this.at += 2;
    return this.view.getInt16(this.at - 2, true);
  }
  u32(): number {
    this.at += 4;
    return this.view.getUint32(this.at - 4, true);
  }
  f32(): number {
    this.at += 4;
    return this.view.getFloat32(this.at - 4, true);
  }
  f64(): number {
    this.at += 8;
    return this.view.getFloat64(this.at - 8, true);
  }
  /** All bytes that follow. */
  rest(): Uint8Array<ArrayBuffer> {
    return new Uint8Array(this.view.buffer, this.at);
  }
  list<T>(count: number, item: () => T): T[] {
    return Array.from({ length: count }, item);
  }
  vector(): Vector {
    return [this.f32(), this.f32(), this.f32()];
  }
  pose(): Pose {
    return [...this.vector(), this.f32(), this.f32(), this.f32(), this.f32()];
  }
}

const FORCE_UNIT = 0.25;

export function readMessage(bytes: ArrayBuffer): { frame: Frame } | { scan: Scan } | { picture: Picture } | null {
  const reader = new Reader(new DataView(bytes));
  const kind = reader.u8();
  if (kind === 1) {
    const time = reader.f64();
    const robots = reader.list(reader.u16(), () => readRobot(reader));
    const objects = reader.list(reader.u16(), () => ({ number: reader.u32(), pose: reader.pose() }));
    return { frame: { time, robots, objects } };
  }
  if (kind === 2) {
    const robot = reader.u32();
    const sensor = reader.u8();
    return { scan: { robot, sensor, ranges: reader.list(reader.u16(), () => reader.u16() / 65535) } };
  }
  if (kind === 3) {
    const robot = reader.u32();
    const sensor = reader.u8();
    return { picture: { robot, sensor, time: reader.f64(), png: reader.rest() } };
  }
  return null;
}

function readRobot(reader: Reader): RobotState {
  const id = reader.u32();
  const pose = reader.pose();
  const linear = reader.vector();
  const angular = reader.vector();
  const wheels = reader.list(reader.u8(), () => {
    const [angle, speed, target] = reader.vector();
    return { angle, speed, target, rollers: reader.list(reader.u8(), () => (reader.i16() / 32768) * Math.PI) };
  });
  const links = reader.list(reader.u8(), () => reader.pose());
  const joints = reader.list(reader.u8(), () => ({ position: reader.f32(), speed: reader.f32() }));
  const force = () => reader.i16() * FORCE_UNIT;
  const contacts = reader.list(reader.u8(), () => {
    const point = reader.vector();
    return { point, force: [force(), force(), force()] as Vector };
  });
  return { id, pose, linear, angular, wheels, links, joints, contacts };
}

/** Roll, pitch, yaw of a pose, rad, as the wire writes them. */
export function rollPitchYaw([, , , x, y, z, w]: Pose): Vector {
  return [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x)))),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
  ];
}
