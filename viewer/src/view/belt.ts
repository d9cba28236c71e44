/** Belts of tracks: pads that move along a closed path around a sprocket. */

import * as THREE from 'three';
import type { Wheel } from '../protocol/scene';
import { coloured } from './solid';

type Belt = NonNullable<Wheel['belt']>;

/** A pad, with its length along x and its outside along z. */
export function pad({ size, colour }: Belt): THREE.BufferGeometry {
  return coloured(new THREE.BoxGeometry(...size), () => colour);
}

/** Returns the poses of the pads in the wheel's frame at an angle of the sprocket, rad. */
export function padPoses({ path, pads, radius }: Belt, angle: number): THREE.Matrix4[] {
  const edges = path.map((from, index) => {
    const to = path[(index + 1) % path.length] ?? from;
    return { from, along: to[0] - from[0], down: to[1] - from[1] };
  });
  const lengths = edges.map(({ along, down }) => Math.hypot(along, down));
  const length = lengths.reduce((sum, edge) => sum + edge, 0);
  if (length === 0) return [];
  const travelled = (radius * angle) % length;
  return Array.from({ length: pads }, (_, number) => {
    let rest = (travelled + (length * number) / pads + length) % length;
    let index = 0;
    while (index < edges.length - 1 && rest > (lengths[index] ?? 0)) rest -= lengths[index++] ?? 0;
    const { from, along, down } = edges[index] as (typeof edges)[number];
    const part = rest / (lengths[index] || 1);
    const place = new THREE.Matrix4().makeTranslation(from[0] + along * part, 0, from[1] + down * part);
    return place.multiply(new THREE.Matrix4().makeRotationY(-Math.atan2(down, along)));
  });
}
