/** The scene as `/scene.json` gives it: SI units, z down. Those in scene.gen.ts and shape.gen.ts are generated from Rust. */

import type { RobotClass, Scene, Spawned } from './scene.gen';
import { fetchWithToken } from './token';

export type {
  Camera,
  Drawn,
  Gripper,
  Joint,
  NamedPlace,
  RobotClass,
  Scene,
  Sensor,
  Solid,
  Spawned,
  Wheel,
} from './scene.gen';
export type { HeightField, Shape } from './shape.gen';

/** Position x y z and quaternion x y z w. */
export type Pose = [number, number, number, number, number, number, number];
export type Vector = [number, number, number];
export type Colour = [number, number, number];

export async function fetchScene(): Promise<Scene> {
  return (await fetchJson('scene.json')) as Scene;
}

export async function fetchClass(name: string): Promise<RobotClass> {
  return (await fetchJson(`class/${encodeURIComponent(name)}`)) as RobotClass;
}

export async function fetchObjects(): Promise<Spawned[]> {
  return (await fetchJson('objects.json')) as Spawned[];
}

async function fetchJson(name: string): Promise<unknown> {
  return (await fetchWithToken(name, { cache: 'no-store' })).json();
}
