/**
 * The messages of a log: our own are described in crates/recorder/proto/usarsim.proto, `FrameTransforms` and `LaserScan` by
 * Foxglove (docs.foxglove.dev/docs/sdk/schemas). What is 0 is not in a message.
 */

import type { ObjectState } from '../protocol/frame';
import type { Pose, Vector } from '../protocol/scene';
import type { Quantity, Reading } from '../protocol/sensors';
import { eachField } from './protobuf';

export interface StateMessage {
  robot: number;
  class: string;
  name: string;
  pose: Pose;
  /** Velocity in world axes, m/s and rad/s. */
  linear: Vector;
  angular: Vector;
  /** Joints in the order of the class's `values`. */
  positions: number[];
  speeds: number[];
}

export interface LineMessage {
  connection: number;
  robot: number | null;
  line: string;
}

type Quaternion = [number, number, number, number];
const NO_TURN: Quaternion = [0, 0, 0, 1];

/** Fields 1 to 3. */
function vector(bytes: Uint8Array): Vector {
  const vector: Vector = [0, 0, 0];
  eachField(bytes, {
    1: (it) => (vector[0] = it.double()),
    2: (it) => (vector[1] = it.double()),
    3: (it) => (vector[2] = it.double()),
  });
  return vector;
}

/** Fields 1 to 4. */
function quaternion(bytes: Uint8Array): Quaternion {
  let w = 0;
  const [x, y, z] = vector(bytes);
  eachField(bytes, { 4: (it) => (w = it.double()) });
  return [x, y, z, w];
}

export function readState(bytes: Uint8Array): StateMessage {
  let [position, linear, angular]: Vector[] = [
    [0, 0, 0],
    [0, 0, 0],
    [0, 0, 0],
  ];
  let turn = NO_TURN;
  const state = { robot: 0, class: '', name: '', positions: [] as number[], speeds: [] as number[] };
  eachField(bytes, {
    1: (it) => (state.robot = it.varint()),
    2: (it) => (state.class = it.text()),
    3: (it) => (state.name = it.text()),
    4: (it) => (position = vector(it.message())),
    5: (it) => (turn = quaternion(it.message())),
    6: (it) => (linear = vector(it.message())),
    7: (it) => (angular = vector(it.message())),
    8: (it) => state.positions.push(...it.doubles()),
    9: (it) => state.speeds.push(...it.doubles()),
  });
  return { ...state, pose: [...position!, ...turn], linear: linear!, angular: angular! };
}

export function readObject(bytes: Uint8Array): ObjectState {
  let [number, position, turn]: [number, Vector, Quaternion] = [0, [0, 0, 0], NO_TURN];
  eachField(bytes, {
    1: (it) => (number = it.varint()),
    3: (it) => (position = vector(it.message())),
    4: (it) => (turn = quaternion(it.message())),
  });
  return { number, pose: [...position, ...turn] };
}

export function readSpawned(bytes: Uint8Array): { number: number; definition: string } {
  const spawned = { number: 0, definition: '' };
  eachField(bytes, {
    1: (it) => (spawned.number = it.varint()),
    2: (it) => (spawned.definition = it.text()),
  });
  return spawned;
}

export function readLine(bytes: Uint8Array): LineMessage {
  const line: LineMessage = { connection: 0, robot: null, line: '' };
  eachField(bytes, {
    1: (it) => (line.connection = it.varint()),
    2: (it) => (line.robot = it.varint()),
    3: (it) => (line.line = it.text()),
  });
  return line;
}

/** Reads the robot and connection of a line, without its text. */
export function readLineOwner(bytes: Uint8Array): { connection: number; robot: number | null } {
  const owner = { connection: 0, robot: null as number | null };
  eachField(bytes, {
    1: (it) => (owner.connection = it.varint()),
    2: (it) => (owner.robot = it.varint()),
  });
  return owner;
}

/** The number of a robot that left, or of an object that was removed. */
export function readLeft(bytes: Uint8Array): number {
  let left = 0;
  eachField(bytes, { 1: (it) => (left = it.varint()) });
  return left;
}

/** Poses by the frames that they are of. */
export function readTransforms(bytes: Uint8Array): Map<string, Pose> {
  const transforms = new Map<string, Pose>();
  const read = (transform: Uint8Array) => {
    let [frame, position, turn]: [string, Vector, Quaternion] = ['', [0, 0, 0], NO_TURN];
    eachField(transform, {
      3: (it) => (frame = it.text()),
      4: (it) => (position = vector(it.message())),
      5: (it) => (turn = quaternion(it.message())),
    });
    transforms.set(frame, [...position, ...turn]);
  };
  eachField(bytes, { 1: (it) => read(it.message()) });
  return transforms;
}

/** Reads a reading without its time. */
export function readReading(bytes: Uint8Array): Omit<Reading, 'time'> {
  const reading = { robot: 0, sensor: 0, type: '', quantities: [] as Quantity[] };
  const quantity = (bytes: Uint8Array) => {
    const quantity: Quantity = { name: '', unit: '', values: [] };
    eachField(bytes, {
      1: (it) => (quantity.name = it.text()),
      2: (it) => (quantity.unit = it.text()),
      3: (it) => (quantity.values = quantity.values.concat(it.doubles())),
    });
    return quantity;
  };
  eachField(bytes, {
    1: (it) => (reading.robot = it.varint()),
    2: (it) => (reading.sensor = it.varint()),
    3: (it) => (reading.type = it.text()),
    4: (it) => reading.quantities.push(quantity(it.message())),
  });
  return reading;
}

/** The ranges of a scan, m. */
export function readRanges(bytes: Uint8Array): number[] {
  let ranges: number[] = [];
  eachField(bytes, { 6: (it) => (ranges = ranges.concat(it.doubles())) });
  return ranges;
}
