/**
 * The binary messages of `/live`. crates/page-protocol/proto/live.proto defines them, and `npm run generate` makes their reader.
 */

import { PbfReader } from 'pbf';
import * as live from './live.pb.js';
import type { Pose, Spawned, Vector } from './scene';

export interface WheelState {
  /** rad */
  angle: number;
  /** rad/s */
  speed: number;
  /** rad/s */
  target: number;
  /** Angles about the rollers' own axes, rad. */
  rollers: number[];
}

export interface Contact {
  point: Vector;
  /** N */
  force: Vector;
  /** Number of the wheel in `wheels`; null for another part. */
  wheel: number | null;
  /** m/s */
  slip: Vector;
  /** Friction over the most that the contact can give. */
  share: number;
}

export interface RobotState {
  id: number;
  pose: Pose;
  /** Velocity along the robot's own axes, m/s. */
  linear: Vector;
  /** Turn rates about the robot's own axes, rad/s. */
  angular: Vector;
  wheels: WheelState[];
  /** Poses of the links that are no wheels, in the robot frame. */
  links: Pose[];
  /** Joints that go to positions: rad and rad/s, or m and m/s. */
  joints: { position: number; speed: number }[];
  contacts: Contact[];
}

/** Pose of a movable object. */
export interface ObjectState {
  /** Number of the object. The map's objects come first, in its order. */
  number: number;
  pose: Pose;
}

/** A spring by which somebody pulls a robot or an object. */
export interface Pull {
  /** Point at which it pulls, and place to which it pulls, m. */
  from: Vector;
  to: Vector;
  /** N */
  force: number;
}

export interface Frame {
  /** Simulated time, s. */
  time: number;
  robots: RobotState[];
  /** Objects in the world. An object of the map that is missing here was removed. */
  objects: ObjectState[];
  /** None in a log: it has the lines that pulled. */
  pulls: Pull[];
}

export interface Scan {
  robot: number;
  sensor: number;
  /** Ranges as parts of the sensor's greatest range. */
  ranges: number[];
}

/** A beam that comes back from nothing is at its range. */
const NOTHING = 0.9995;

/** True if a beam with a range, as a part of the greatest, met something. */
export function isHit(range: number): boolean {
  return range > 0 && range < NOTHING;
}

/** Picture of a camera. */
export interface Picture {
  robot: number;
  sensor: number;
  /** Simulated time, s. */
  time: number;
  /** A PNG file. */
  png: Uint8Array<ArrayBuffer>;
  /** Angle from its left to its right edge, rad. */
  field_of_view: number;
}

/** The run before the page was opened. */
export interface Past {
  /** Number of times that the world started over before it. */
  resets: number;
  /** Frames from all of it, the oldest first, as `readMessage` takes them. */
  frames: ArrayBuffer[];
  /** Robots that are in them. */
  robots: live.Known[];
  /** Objects that are in them and not in the map. */
  objects: Spawned[];
}

/** Unit of a force, N. */
const FORCE_UNIT = 0.25;
/** Unit of a slip, m/s. */
const SLIP_UNIT = 1e-4;
/** Units of a roller's angle in pi. */
const HALF_TURN = 32768;
/** Units of a range in a sensor's greatest range. */
const FULL_RANGE = 65535;

export function readMessage(bytes: ArrayBuffer): { frame: Frame } | { scan: Scan } | { picture: Picture } | null {
  const { frame, scan, picture } = live.readMessage(new PbfReader(bytes), bytes.byteLength);
  if (frame) {
    const objects = frame.objects.map((it) => ({ number: it.object, pose: it.pose as Pose }));
    const pulls = frame.pulls.map(({ line, force }) => {
      return { from: line.slice(0, 3) as Vector, to: line.slice(3) as Vector, force };
    });
    return { frame: { time: frame.time, robots: frame.robots.map(readRobot), objects, pulls } };
  }
  if (scan) {
    const ranges = scan.ranges.map((range) => range / FULL_RANGE);
    return { scan: { robot: scan.robot, sensor: scan.sensor, ranges } };
  }
  if (picture) {
    return { picture: { ...picture, png: picture.png ?? new Uint8Array() } };
  }
  return null;
}

export function readPast(bytes: ArrayBuffer): Past {
  const { frames, objects, ...past } = live.readPast(new PbfReader(bytes), bytes.byteLength);
  return {
    ...past,
    frames: frames.map((frame) => frame.slice().buffer),
    objects: objects === '' ? [] : (JSON.parse(objects) as Spawned[]),
  };
}

function readRobot(robot: live.Robot): RobotState {
  const { pose, linear, angular, wheels, links, joint_positions, joint_speeds } = robot;
  return {
    id: robot.robot,
    pose: pose as Pose,
    linear: linear as Vector,
    angular: angular as Vector,
    wheels: wheels.map((wheel) => ({
      ...wheel,
      rollers: wheel.rollers.map((angle) => (angle / HALF_TURN) * Math.PI),
    })),
    links: inParts<Pose>(links, 7),
    joints: joint_positions.map((position, at) => ({ position, speed: joint_speeds[at] ?? 0 })),
    contacts: readContacts(robot),
  };
}

function readContacts(robot: live.Robot): Contact[] {
  const vectors = (numbers: number[], unit: number) =>
    inParts<Vector>(
      numbers.map((part) => part * unit),
      3,
    );
  const forces = vectors(robot.contact_forces, FORCE_UNIT);
  const slips = vectors(robot.contact_slips, SLIP_UNIT);
  return inParts<Vector>(robot.contact_points, 3).map((point, at) => ({
    point,
    force: forces[at] ?? [0, 0, 0],
    wheel: robot.contact_wheels[at] ? robot.contact_wheels[at] - 1 : null,
    slip: slips[at] ?? [0, 0, 0],
    share: (robot.contact_shares[at] ?? 0) / 100,
  }));
}

/** Cuts a list of numbers into parts of a length. */
function inParts<Part extends number[]>(numbers: number[], length: number): Part[] {
  return Array.from(
    { length: Math.floor(numbers.length / length) },
    (_, part) => numbers.slice(part * length, (part + 1) * length) as Part,
  );
}

/** Roll, pitch, yaw of a pose, rad, as the wire writes them. */
export function rollPitchYaw([, , , x, y, z, w]: Pose): Vector {
  return [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x)))),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
  ];
}
