/** Solids of the map as they are drawn: with a picture on every face, darker at the foot, with lines at their edges. */

import * as THREE from 'three';
import type { Pose, Solid } from '../protocol/scene';
import { setPose } from './pose';
import { coloured, shapeGeometry } from './solid';
import { surfaceOf, tileOf } from './surfaces';

/** Darkening of a side at the floor. */
const FOOT = 0.3;
/** Up to this height above its foot a side is darker, m. */
const FOOT_HEIGHT = 1;
/** Faces that meet at more than this have a line between them, degrees. */
const EDGE_ANGLE = 25;
/** Greatest length of a piece of an edge, m: lines that pass behind the camera are drawn badly without a graphics card. */
const EDGE_PIECE = 3;
/** A mesh with more triangles has no lines. */
const EDGE_TRIANGLES = 20_000;

/** The solid at its pose; `number` is its place in the map, or an object's number. */
export function drawnSolid({ shape, material, colour }: Solid, pose: Pose, number: number): THREE.BufferGeometry {
  const shaped = shapeGeometry(shape);
  const geometry = shaped.index ? shaped.toNonIndexed() : shaped;
  // Not all alike where they begin: two walls of one material are told apart.
  pictured(geometry, tileOf(surfaceOf(material)), (number * 0.37) % 1);
  geometry.applyMatrix4(setPose(new THREE.Matrix4(), pose));
  coloured(geometry, colour);
  if (shape !== 'HalfSpace') darkenFoot(geometry);
  return geometry;
}

/** Ends of the lines along the edges of a solid, in pairs. */
export function edgesOf({ shape }: Solid, pose: Pose): number[] {
  if (shape === 'HalfSpace' || 'Ball' in shape || 'HeightField' in shape) return [];
  if ('Mesh' in shape && shape.Mesh.triangles.length > EDGE_TRIANGLES) return [];
  const edges = new THREE.EdgesGeometry(shapeGeometry(shape), EDGE_ANGLE);
  edges.applyMatrix4(setPose(new THREE.Matrix4(), pose));
  const places = edges.getAttribute('position');
  const [from, to] = [new THREE.Vector3(), new THREE.Vector3()];
  const ends: number[] = [];
  for (let line = 0; line < places.count; line += 2) {
    from.fromBufferAttribute(places, line);
    to.fromBufferAttribute(places, line + 1);
    const pieces = Math.ceil(from.distanceTo(to) / EDGE_PIECE);
    for (let piece = 0; piece < pieces; piece++) {
      ends.push(...from.clone().lerp(to, piece / pieces), ...from.clone().lerp(to, (piece + 1) / pieces));
    }
  }
  return ends;
}

/** Lays the picture on every triangle along the two axes that it faces least, the longer one along the grain. */
function pictured(geometry: THREE.BufferGeometry, tile: number, shift: number): void {
  geometry.computeBoundingBox();
  const size = geometry.boundingBox?.getSize(new THREE.Vector3()).toArray() ?? [1, 1, 1];
  const [places, uv] = [geometry.getAttribute('position'), geometry.getAttribute('uv')];
  const [a, b, c] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  for (let first = 0; first < places.count; first += 3) {
    [a, b, c].forEach((corner, index) => corner.fromBufferAttribute(places, first + index));
    const normal = b.clone().sub(a).cross(c.clone().sub(a)).toArray().map(Math.abs);
    const facing = normal.indexOf(Math.max(...normal));
    const [along = 0, across = 1] = [0, 1, 2]
      .filter((axis) => axis !== facing)
      .sort((one, other) => (size[other] ?? 0) - (size[one] ?? 0));
    [a, b, c].forEach((corner, index) => {
      uv.setXY(first + index, corner.getComponent(along) / tile + shift, corner.getComponent(across) / tile + shift);
    });
  }
}

/** Less light comes to a side near the floor. */
function darkenFoot(geometry: THREE.BufferGeometry): void {
  geometry.computeBoundingBox();
  const { min, max } = geometry.boundingBox as THREE.Box3;
  const [places, normals, colours] = ['position', 'normal', 'color'].map((name) => geometry.getAttribute(name));
  if (!places || !normals || !colours) return;
  const height = Math.min(FOOT_HEIGHT, max.z - min.z);
  for (let corner = 0; corner < places.count; corner++) {
    const above = Math.min(1, (max.z - places.getZ(corner)) / (height || 1));
    // A step of a few centimetres is not darkened as much as a wall.
    const dark = FOOT * Math.min(1, height / 0.4) * (1 - above) * (1 - Math.abs(normals.getZ(corner)));
    const [r, g, b] = [colours.getX(corner), colours.getY(corner), colours.getZ(corner)];
    colours.setXYZ(corner, r * (1 - dark), g * (1 - dark), b * (1 - dark));
  }
}
