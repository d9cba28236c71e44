import * as THREE from 'three';
import type { Pose, Vector } from '../protocol/scene';

const ONE = new THREE.Vector3(1, 1, 1);
const place = new THREE.Vector3();
const turn = new THREE.Quaternion();

export function setPose(matrix: THREE.Matrix4, [x, y, z, i, j, k, w]: Pose): THREE.Matrix4 {
  return matrix.compose(place.set(x, y, z), turn.set(i, j, k, w), ONE);
}

export function moveTo(object: THREE.Object3D, [x, y, z, i, j, k, w]: Pose): void {
  object.position.set(x, y, z);
  object.quaternion.set(i, j, k, w);
}

/** Returns a place of the world in the frame of a body. */
export function ownPoint([x, y, z, i, j, k, w]: Pose, place: Vector): Vector {
  const own = new THREE.Vector3(...place).sub(new THREE.Vector3(x, y, z));
  own.applyQuaternion(new THREE.Quaternion(i, j, k, w).conjugate());
  return [own.x, own.y, own.z];
}

/** Returns a point of a body's frame in the frame of its pose. */
export function worldPoint([x, y, z, i, j, k, w]: Pose, own: Vector): Vector {
  const point = new THREE.Vector3(...own).applyQuaternion(new THREE.Quaternion(i, j, k, w));
  return [point.x + x, point.y + y, point.z + z];
}

/** Returns a place of the wire's frame on the stage, where z is up. */
export function onStage([x, y, z]: Vector): THREE.Vector3 {
  return new THREE.Vector3(x, -y, -z);
}

/** Returns a place of the stage in the wire's frame. */
export function onWire({ x, y, z }: THREE.Vector3): Vector {
  return [x, -y, -z];
}
