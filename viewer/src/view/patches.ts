/** Contact patches of tyres, as ellipses at their contacts. */

import * as THREE from 'three';

/** Patches that fit. */
const CAPACITY = 500;
const CORNERS = 24;

export class Patches {
  readonly mesh: THREE.InstancedMesh<THREE.CircleGeometry, THREE.MeshBasicMaterial>;

  constructor() {
    const material = new THREE.MeshBasicMaterial({
      side: THREE.DoubleSide,
      depthTest: false,
      transparent: true,
      opacity: 0.7,
      toneMapped: false,
      fog: false,
    });
    this.mesh = new THREE.InstancedMesh(new THREE.CircleGeometry(1, CORNERS), material, CAPACITY);
    this.mesh.frustumCulled = false;
    // Over the wheel, which hides it.
    this.mesh.renderOrder = 8;
  }

  begin(): void {
    this.mesh.count = 0;
  }

  /** Adds an ellipse, given by its middle and its two half axes. */
  add(middle: THREE.Vector3, along: THREE.Vector3, across: THREE.Vector3, colour: THREE.Color): void {
    if (this.mesh.count === CAPACITY) return;
    const normal = new THREE.Vector3().crossVectors(along, across).normalize();
    const frame = new THREE.Matrix4().makeBasis(along, across, normal).setPosition(middle);
    this.mesh.setMatrixAt(this.mesh.count, frame);
    this.mesh.setColorAt(this.mesh.count, colour);
    this.mesh.count++;
  }

  end(): void {
    this.mesh.visible = this.mesh.count > 0;
    this.mesh.instanceMatrix.needsUpdate = true;
    if (this.mesh.instanceColor) this.mesh.instanceColor.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.material.dispose();
    this.mesh.geometry.dispose();
    this.mesh.dispose();
  }
}
