/** Lines to a hand: springs by which somebody pulls something, with their force, and the way of a link that is led. */

import * as THREE from 'three';
import type { Pull } from '../protocol/frame';
import type { Vector } from '../protocol/scene';
import { Arrows } from './arrows';
import type { Labels } from './labels';
import { onStage } from './pose';

const COLOUR = new THREE.Color(0xf0a020);
/** A shorter spring is not drawn, m. */
const SHORT = 0.01;

/** A point of a link that a joint's servo brings to a place, m. */
export interface Led {
  from: Vector;
  to: Vector;
}

export class Pulls {
  private readonly arrows = new Arrows();
  readonly group = this.arrows.group;

  constructor(private readonly labels: Labels) {}

  /** Draws the springs as they are seen from a place of the world. */
  place(pulls: readonly (Pull | Led)[], eye: THREE.Vector3, pixelsPerMetre: number): void {
    this.arrows.eye.copy(eye);
    this.arrows.pixelsPerMetre = pixelsPerMetre;
    this.arrows.begin();
    const keys = new Set<string>();
    pulls.forEach((pull, number) => {
      const { from, to } = pull;
      const start = new THREE.Vector3(...from);
      const way = new THREE.Vector3(...to).sub(start);
      const length = way.length();
      if (length > SHORT) this.arrows.add(start, way.divideScalar(length), length, COLOUR);
      if (!('force' in pull)) return;
      keys.add(`pull ${number}`);
      this.labels.set(`pull ${number}`, 'pull', newtons(pull.force), onStage(to));
    });
    this.arrows.end();
    this.labels.keep('pull', keys);
  }

  dispose(): void {
    this.arrows.dispose();
  }
}

/** Three figures are enough, and do not flicker. */
function newtons(force: number): string {
  return `${force < 10 ? force.toFixed(1) : Math.round(force)} N`;
}
