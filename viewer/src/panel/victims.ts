/** Victims in the pictures of cameras, each with a box and its distance. */

import * as THREE from 'three';
import type { Picture, RobotState } from '../protocol/frame';
import type { Sensor, Sight, Vector } from '../protocol/scene';
import { mountOf } from '../view/overlay';
import { make } from './dom';

/** Farther victims have no box, m. */
const RANGE = 8;
/** Height of a victim's middle above its place, and half the edge of its box, m. */
const MIDDLE = 0.3;
const HALF = 0.45;
/** Heights of a victim of which one has to be seen, m. */
const SEEN = [0.15, MIDDLE, 0.7];
/** Nearer than this to the victim nothing hides it: that is its own body, m. */
const BODY = 0.3;

/** Returns the boxes of the victims that a camera sees, as parts of its picture. */
export function victimBoxes(
  { field_of_view: across }: Picture,
  sensor: Sensor,
  robot: RobotState,
  victims: readonly Sight[],
  sees: (from: Vector, to: Vector, near: number) => boolean,
): HTMLElement[] {
  const { width, height } = sensor.camera ?? { width: 1, height: 1 };
  const mount = mountOf(sensor, robot);
  const eye = new THREE.Vector3().setFromMatrixPosition(mount);
  const toCamera = mount.clone().invert();
  const reach = Math.tan(across / 2);
  return victims.flatMap(({ name, position: [x, y, z] }) => {
    const middle: Vector = [x, y, z - MIDDLE];
    // The sensor looks along x, with y to the right and z down.
    const { x: ahead, y: right, z: down } = new THREE.Vector3(...middle).applyMatrix4(toCamera);
    const distance = Math.hypot(ahead, right, down);
    const [u, v] = [right / ahead / reach, (down / ahead / reach) * (width / height)];
    if (ahead < 0.1 || distance > RANGE || Math.abs(u) > 1 || Math.abs(v) > 1) return [];
    if (!SEEN.some((height) => sees([eye.x, eye.y, eye.z], [x, y, z - height], BODY))) return [];
    const half = HALF / ahead / reach / 2;
    const box = make('div', { class: 'victim-box', 'data-victim': name }, `${name} ${distance.toFixed(1)} m`);
    const [left, top] = [(u + 1) / 2 - half, (v + 1) / 2 - half * (width / height)];
    const part = (number: number) => `${(100 * number).toFixed(1)}%`;
    Object.assign(box.style, {
      left: part(left),
      top: part(top),
      width: part(2 * half),
      height: part(2 * half * (width / height)),
    });
    return [box];
  });
}
