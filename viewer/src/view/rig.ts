/** Pose of a camera by its target, angles and distance, and its turns, shifts and zooms. Metres, rad, z up. */

import * as THREE from 'three';

export interface Aim {
  target: THREE.Vector3;
  /** Direction of the look over the ground, 0 along x, counterclockwise. */
  yaw: number;
  /** Angle at which it looks down, up to a quarter turn. */
  pitch: number;
  /** Distance from the target. */
  distance: number;
}

/** The least height above the floor, and distances that can be chosen, m. */
const LEAST_HEIGHT = 0.06;
export const LEAST_DISTANCE = 0.15;
export const GREATEST_DISTANCE = 400;
const STEEPEST = Math.PI / 2;

export function copyAim({ target, yaw, pitch, distance }: Aim): Aim {
  return { target: target.clone(), yaw, pitch, distance };
}

/** The direction of the look. */
export function forward({ yaw, pitch }: Aim): THREE.Vector3 {
  return new THREE.Vector3(Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), -Math.sin(pitch));
}

export function right({ yaw }: Aim): THREE.Vector3 {
  return new THREE.Vector3(Math.sin(yaw), -Math.cos(yaw), 0);
}

export function eyeOf(aim: Aim): THREE.Vector3 {
  return aim.target.clone().addScaledVector(forward(aim), -aim.distance);
}

/** Looks the same, but turns and zooms about what is so deep in the picture. */
export function anchor(aim: Aim, place: THREE.Vector3): void {
  const [eye, ahead] = [eyeOf(aim), forward(aim)];
  const depth = place.clone().sub(eye).dot(ahead);
  if (depth < LEAST_DISTANCE) return;
  aim.distance = Math.min(GREATEST_DISTANCE, depth);
  aim.target.copy(eye).addScaledVector(ahead, aim.distance);
}

/** Turns about a place, which stays where it is in the picture; never below the floor. */
export function turn(aim: Aim, about: THREE.Vector3, yaw: number, pitch: number): void {
  const up = new THREE.Vector3(0, 0, 1);
  aim.target.sub(about).applyAxisAngle(up, yaw).add(about);
  aim.yaw += yaw;
  const before = copyAim(aim);
  const steeper = Math.max(-STEEPEST, Math.min(STEEPEST, aim.pitch + pitch)) - aim.pitch;
  // About the axis to the right, looking down is a negative turn.
  aim.target.sub(about).applyAxisAngle(right(aim), -steeper).add(about);
  aim.pitch += steeper;
  const height = eyeOf(aim).z;
  if (height < LEAST_HEIGHT && height < eyeOf(before).z) {
    aim.target.copy(before.target);
    aim.pitch = before.pitch;
  }
}

/** Comes so many times nearer to a place, which stays where it is in the picture. */
export function zoom(aim: Aim, about: THREE.Vector3, factor: number): void {
  const distance = Math.max(LEAST_DISTANCE, Math.min(GREATEST_DISTANCE, aim.distance * factor));
  const own = distance / aim.distance;
  aim.distance = distance;
  aim.target.sub(about).multiplyScalar(own).add(about);
  keepAbove(aim);
}

/** Shifts the picture by parts of its height, as if what is looked at were held. */
export function pan(aim: Aim, x: number, y: number, fov: number): void {
  const height = 2 * aim.distance * Math.tan(fov / 2);
  const ahead = new THREE.Vector3(Math.cos(aim.yaw), Math.sin(aim.yaw), 0);
  aim.target.addScaledVector(right(aim), -x * height);
  // Over the ground, so flat looks go farther; but not without end.
  aim.target.addScaledVector(ahead, (y * height) / Math.max(0.35, Math.sin(Math.abs(aim.pitch))));
}

export function keepAbove(aim: Aim): void {
  aim.target.z += Math.max(0, LEAST_HEIGHT - eyeOf(aim).z);
}

/** Interpolates between two aims, 0 to 1, the shorter way round. */
export function between(from: Aim, to: Aim, part: number): Aim {
  const way = Math.atan2(Math.sin(to.yaw - from.yaw), Math.cos(to.yaw - from.yaw));
  return {
    target: from.target.clone().lerp(to.target, part),
    yaw: from.yaw + way * part,
    pitch: from.pitch + (to.pitch - from.pitch) * part,
    distance: from.distance * (to.distance / from.distance) ** part,
  };
}

/** The aim of the same direction from which a box is seen whole. */
export function fitted({ yaw, pitch }: Aim, box: THREE.Box3, fov: number, aspect: number, fill: number): Aim {
  const aim = { target: box.getCenter(new THREE.Vector3()), yaw, pitch, distance: 1 };
  const [ahead, aside] = [forward(aim), right(aim)];
  const up = aside.clone().cross(ahead);
  const [vertical, horizontal] = [fill * Math.tan(fov / 2), fill * aspect * Math.tan(fov / 2)];
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((corner) =>
    new THREE.Vector3(
      corner & 1 ? box.max.x : box.min.x,
      corner & 2 ? box.max.y : box.min.y,
      corner & 4 ? box.max.z : box.min.z,
    ).sub(aim.target),
  );
  const needed = corners.map((corner) => {
    const wide = Math.abs(corner.dot(aside)) / horizontal;
    const high = Math.abs(corner.dot(up)) / vertical;
    return Math.max(wide, high) - corner.dot(ahead);
  });
  aim.distance = Math.max(LEAST_DISTANCE, ...needed);
  return aim;
}

/** Puts a camera there. */
export function applyAim(aim: Aim, camera: THREE.Camera): void {
  const [ahead, aside] = [forward(aim), right(aim)];
  const up = aside.clone().cross(ahead);
  camera.position.copy(eyeOf(aim));
  camera.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(aside, up, ahead.negate()));
}
