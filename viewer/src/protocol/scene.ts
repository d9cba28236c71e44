/** The scene as `/scene.json` gives it: SI units, z down; poses are x y z and a quaternion x y z w. */

export type Pose = [number, number, number, number, number, number, number];
export type Vector = [number, number, number];
export type Colour = [number, number, number];

export type Shape =
  | 'HalfSpace'
  | { Box: { size: Vector } }
  | { Cylinder: { radius: number; length: number } }
  | { Ball: { radius: number } }
  | { Mesh: { vertices: Vector[]; triangles: Vector[] } }
  /** in logs alone: the server makes a mesh of it */
  | { Hull: { points: Vector[] } };

export interface Solid {
  name: string;
  shape: Shape;
  pose: Pose;
  material: string;
  colour: Colour;
  friction: number;
}

/** An object that the map does not have. */
export interface Spawned extends Solid {
  number: number;
}

/** A piece of a robot in the frame of its link. */
export interface Drawn {
  shape: Shape;
  pose: Pose;
  colour: Colour;
}

export interface NamedPlace {
  name: string;
  position: Vector;
  rotation: Vector;
}

export interface Wheel {
  name: string;
  /** the number among `links` of what carries it; null is the body */
  link: number | null;
  /** in the frame of what carries it */
  position: Vector;
  /** beside its rollers */
  drawn: Drawn[];
  max_speed: number | null;
  rollers: { poses: Pose[]; outline: [number, number][]; colour: Colour } | null;
}

/** Size of a camera's pictures, pixels. */
export interface Camera {
  width: number;
  height: number;
}

export interface Sensor {
  name: string;
  /** the number among `links` of what carries it; null is the body */
  link: number | null;
  /** in the frame of what carries it */
  pose: Pose;
  max_range: number | null;
  fan: { first: number; resolution: number; level: boolean } | null;
  /** null for what is no camera; scenes of older servers do not say it */
  camera?: Camera | null;
}

/** A joint that goes to a position. */
export interface Joint {
  name: string;
  min: number;
  max: number;
  /** scenes of older servers do not say it */
  unit?: 'rad' | 'm';
}

/** Joints that open and close together. */
export interface Gripper {
  name: string;
  joints: string[];
  /** where each joint is, rad or m */
  open: number[];
  closed: number[];
}

export interface RobotClass {
  description: string;
  steering: 'SkidSteered' | 'OmniDrive' | 'AckermanSteered' | 'Aerial' | 'Legged' | 'None';
  /** of front and rear, rad */
  max_steer: [number, number];
  drive_model: string;
  wheel_radius: number;
  track: number;
  wheel_base: number;
  /** the body */
  drawn: Drawn[];
  /** what hangs on the body beside driven wheels */
  links: { name: string; drawn: Drawn[] }[];
  wheels: Wheel[];
  joints: Joint[];
  /** scenes of older servers have none */
  grippers?: Gripper[];
  sensors: Sensor[];
}

export interface Scene {
  version: string;
  seed: number;
  port: number;
  /** s */
  time_step: number;
  /** those that the server can change to */
  maps: { name: string; description: string }[];
  map: {
    name: string;
    description: string;
    solids: Solid[];
    objects: Solid[];
    starts: NamedPlace[];
    path_nodes: NamedPlace[];
  };
  classes: Record<string, RobotClass>;
}

export async function fetchScene(): Promise<Scene> {
  return (await fetchJson('scene.json')) as Scene;
}

export async function fetchObjects(): Promise<Spawned[]> {
  return (await fetchJson('objects.json')) as Spawned[];
}

async function fetchJson(name: string): Promise<unknown> {
  const response = await fetch(name, { cache: 'no-store' });
  if (!response.ok) {
    throw new Error(`${name}: ${response.status} ${await response.text()}`);
  }
  return response.json();
}
