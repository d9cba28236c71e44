// Generated from crates/page-protocol/proto/live.proto by `npm run generate`.

import type { PbfReader } from 'pbf';

export interface Message {
  frame: Frame | undefined;
  scan: Scan | undefined;
  picture: Picture | undefined;
}
export function readMessage(pbf: PbfReader, end?: number): Message;

export interface Frame {
  time: number;
  robots: Robot[];
  objects: Placed[];
  pulls: Pull[];
}
export function readFrame(pbf: PbfReader, end?: number): Frame;

export interface Robot {
  robot: number;
  pose: number[];
  linear: number[];
  angular: number[];
  wheels: Wheel[];
  links: number[];
  joint_positions: number[];
  joint_speeds: number[];
  contact_points: number[];
  contact_forces: number[];
  contact_wheels: number[];
  contact_slips: number[];
  contact_shares: number[];
}
export function readRobot(pbf: PbfReader, end?: number): Robot;

export interface Wheel {
  angle: number;
  speed: number;
  target: number;
  rollers: number[];
}
export function readWheel(pbf: PbfReader, end?: number): Wheel;

export interface Placed {
  object: number;
  pose: number[];
}
export function readPlaced(pbf: PbfReader, end?: number): Placed;

export interface Pull {
  line: number[];
  force: number;
}
export function readPull(pbf: PbfReader, end?: number): Pull;

export interface Scan {
  robot: number;
  sensor: number;
  ranges: number[];
}
export function readScan(pbf: PbfReader, end?: number): Scan;

export interface Picture {
  robot: number;
  sensor: number;
  time: number;
  png: Uint8Array<ArrayBuffer> | undefined;
  field_of_view: number;
}
export function readPicture(pbf: PbfReader, end?: number): Picture;

export interface Past {
  resets: number;
  frames: Uint8Array<ArrayBuffer>[];
  robots: Known[];
  objects: string;
}
export function readPast(pbf: PbfReader, end?: number): Past;

export interface Known {
  robot: number;
  class: string;
  name: string;
  came: number;
  left: number;
}
export function readKnown(pbf: PbfReader, end?: number): Known;
