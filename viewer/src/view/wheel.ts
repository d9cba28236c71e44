/** Wheels and their rollers as geometries on which one sees them turn. */

import * as THREE from 'three';
import type { Colour, Drawn } from '../protocol/scene';
import { coloured, solidGeometry } from './solid';

/** A roller's stripe, by which one sees it turn. */
const STRIPE: Colour = [0.62, 0.62, 0.64];

/** A piece of a wheel, which turns about y, with a lighter sector. */
export function spoked({ shape, pose, colour }: Drawn): THREE.BufferGeometry {
  const lighter = colour.map((part) => Math.min(1, part + 0.22)) as Colour;
  const isSector = (x: number, z: number) => Math.abs(Math.atan2(z, x)) < 0.3;
  return solidGeometry(shape, pose, (x, _, z) => (isSector(x, z) ? lighter : colour));
}

/** A roller's outline turned about its x axis, exact from near and with a few corners for afar. */
export function roller(outline: [number, number][], colour: Colour, near: boolean): THREE.BufferGeometry {
  const middle = outline[outline.length >> 1] ?? [0, 0];
  const [first, last] = [outline[0] ?? middle, outline[outline.length - 1] ?? middle];
  const drawn = near ? outline : [first, middle, last];
  const points = drawn.map(([along, radius]) => new THREE.Vector2(radius, along));
  points.unshift(new THREE.Vector2(0, first[0]));
  points.push(new THREE.Vector2(0, last[0]));
  // The lathe turns about y.
  const geometry = new THREE.LatheGeometry(points, near ? 12 : 5).rotateZ(-Math.PI / 2);
  return coloured(geometry, (_, y, z) => (Math.abs(Math.atan2(z, y)) < 0.35 ? STRIPE : colour));
}
