/** Places of a league's goals: boxes and circles, in another colour once they are reached. */

import * as THREE from 'three';
import type { Scene } from '../protocol/scene';

/** Colours of goals that are open, and of those that are reached. */
const OPEN = new THREE.Color('#d97a00');
const REACHED = new THREE.Color('#12884a');
/** Width of a circle's line, and its height above the ground, m. */
const LINE = 0.03;
const HEIGHT = 0.006;
const CORNERS = 48;

export class Targets {
  readonly group = new THREE.Group();
  private readonly colours = new Map<string, THREE.Color[]>();

  constructor({ league }: Scene) {
    for (const { name, position, size, radius } of league?.targets ?? []) {
      const shape = size ? box(size) : circle(radius ?? 1);
      shape.position.set(...position);
      // It lies on the ground, which is up where z is down.
      if (!size) shape.position.z -= HEIGHT;
      this.group.add(shape);
      this.colours.set(name, [...(this.colours.get(name) ?? []), shape.material.color]);
    }
    this.setReached([]);
  }

  setReached(names: readonly string[]): void {
    for (const [name, colours] of this.colours) {
      colours.forEach((colour) => colour.copy(names.includes(name) ? REACHED : OPEN));
    }
  }

  dispose(): void {
    for (const child of this.group.children as Shape[]) {
      child.geometry.dispose();
      child.material.dispose();
    }
  }
}

type Shape = ReturnType<typeof box> | ReturnType<typeof circle>;

function box(size: [number, number, number]) {
  const edges = new THREE.EdgesGeometry(new THREE.BoxGeometry(...size));
  return new THREE.LineSegments(edges, new THREE.LineBasicMaterial({ transparent: true, opacity: 0.8 }));
}

function circle(radius: number) {
  const ring = new THREE.RingGeometry(Math.max(0, radius - LINE), radius, CORNERS);
  return new THREE.Mesh(ring, new THREE.MeshBasicMaterial({ side: THREE.DoubleSide, transparent: true, opacity: 0.8 }));
}
