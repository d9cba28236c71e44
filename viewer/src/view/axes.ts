/** Frames of robots and sensors as three lines each. */

import * as THREE from 'three';
import { AXIS_COLOURS } from './colours';

/** Frames that fit; corners of the lines of one. */
const CAPACITY = 1000;
const CORNERS = 6;

export class Axes {
  readonly lines: THREE.LineSegments;
  private count = 0;

  constructor() {
    const geometry = new THREE.BufferGeometry();
    const numbers = () => new THREE.BufferAttribute(new Float32Array(3 * CORNERS * CAPACITY), 3);
    geometry.setAttribute('position', numbers());
    geometry.setAttribute('color', numbers());
    const tints = AXIS_COLOURS.map((colour) => new THREE.Color(colour));
    const colours = geometry.getAttribute('color');
    for (let corner = 0; corner < colours.count; corner++) {
      tints[(corner % CORNERS) >> 1]?.toArray(colours.array as Float32Array, 3 * corner);
    }
    const material = new THREE.LineBasicMaterial({ vertexColors: true, depthTest: false, transparent: true });
    this.lines = new THREE.LineSegments(geometry, material);
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 9;
  }

  begin(): void {
    this.count = 0;
  }

  add(frame: THREE.Matrix4, length: number): void {
    if (this.count === CAPACITY) return;
    const places = this.lines.geometry.getAttribute('position');
    const [origin, end] = [new THREE.Vector3().setFromMatrixPosition(frame), new THREE.Vector3()];
    for (let axis = 0; axis < 3; axis++) {
      const corner = CORNERS * this.count + 2 * axis;
      places.setXYZ(corner, ...origin.toArray());
      places.setXYZ(corner + 1, ...end.setScalar(0).setComponent(axis, length).applyMatrix4(frame).toArray());
    }
    this.count++;
  }

  end(): void {
    this.lines.geometry.setDrawRange(0, CORNERS * this.count);
    this.lines.geometry.getAttribute('position').needsUpdate = true;
  }

  dispose(): void {
    this.lines.geometry.dispose();
    (this.lines.material as THREE.Material).dispose();
  }
}
