/** Arrows whose number changes from frame to frame: all shafts are one mesh, all heads another. */

import * as THREE from 'three';

const RADIUS = 0.005;
const HEAD = { radius: 0.014, length: 0.035 };
const UP = new THREE.Vector3(0, 1, 0);
/** The least breadth of a shaft on the screen, px. */
const LEAST_BREADTH = 3;
/** Arrows that fit. */
const CAPACITY = 2000;

export class Arrows {
  readonly group = new THREE.Group();
  /** Eye that sees them, and pixels of a metre at a distance of one metre. */
  readonly eye = new THREE.Vector3();
  pixelsPerMetre = 500;
  private readonly material: THREE.MeshBasicMaterial;
  private readonly shafts: THREE.InstancedMesh;
  private readonly heads: THREE.InstancedMesh;
  private count = 0;

  constructor() {
    this.material = new THREE.MeshBasicMaterial({
      depthTest: false,
      transparent: true,
      toneMapped: false,
      fog: false,
    });
    const shaft = new THREE.CylinderGeometry(RADIUS, RADIUS, 1, 6).translate(0, 0.5, 0);
    const head = new THREE.ConeGeometry(HEAD.radius, HEAD.length, 10).translate(0, HEAD.length / 2, 0);
    this.shafts = new THREE.InstancedMesh(shaft, this.material, CAPACITY);
    this.heads = new THREE.InstancedMesh(head, this.material, CAPACITY);
    for (const mesh of [this.shafts, this.heads]) {
      mesh.frustumCulled = false;
      // Over all, since contacts are hidden by their wheels.
      mesh.renderOrder = 9;
      this.group.add(mesh);
    }
  }

  begin(): void {
    this.count = 0;
  }

  add(from: THREE.Vector3, direction: THREE.Vector3, length: number, colour: THREE.Color): void {
    if (this.count === CAPACITY) return;
    const turn = new THREE.Quaternion().setFromUnitVectors(UP, direction);
    const matrix = new THREE.Matrix4();
    const metresPerPixel = from.distanceTo(this.eye) / this.pixelsPerMetre;
    const broad = Math.max(1, (LEAST_BREADTH * metresPerPixel) / (2 * RADIUS));
    this.shafts.setMatrixAt(this.count, matrix.compose(from, turn, new THREE.Vector3(broad, length, broad)));
    const end = from.clone().addScaledVector(direction, length);
    this.heads.setMatrixAt(this.count, matrix.compose(end, turn, new THREE.Vector3(broad, broad, broad)));
    for (const mesh of [this.shafts, this.heads]) mesh.setColorAt(this.count, colour);
    this.count++;
  }

  end(): void {
    for (const mesh of [this.shafts, this.heads]) {
      mesh.count = this.count;
      mesh.visible = this.count > 0;
      mesh.instanceMatrix.needsUpdate = true;
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }

  dispose(): void {
    this.material.dispose();
    for (const mesh of [this.shafts, this.heads]) {
      mesh.geometry.dispose();
      mesh.dispose();
    }
  }
}
