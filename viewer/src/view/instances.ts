/** An instanced mesh that grows. */

import * as THREE from 'three';
import type { Surfaces } from './surfaces';

export class Instances {
  mesh: THREE.InstancedMesh;
  private count = 0;

  constructor(
    private readonly parent: THREE.Group,
    geometry: THREE.BufferGeometry,
    private readonly surfaces: Surfaces,
  ) {
    this.mesh = this.make(geometry, 1);
  }

  begin(): void {
    this.count = 0;
  }

  add(matrix: THREE.Matrix4): void {
    if (this.count === this.mesh.instanceMatrix.count) this.grow();
    this.mesh.setMatrixAt(this.count++, matrix);
  }

  end(): void {
    this.mesh.count = this.count;
    this.mesh.visible = this.count > 0;
    this.mesh.instanceMatrix.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.dispose();
  }

  private grow(): void {
    const { mesh } = this;
    this.parent.remove(mesh);
    this.mesh = this.make(mesh.geometry, 2 * this.count);
    this.mesh.instanceMatrix.array.set(mesh.instanceMatrix.array);
    mesh.dispose();
  }

  private make(geometry: THREE.BufferGeometry, capacity: number): THREE.InstancedMesh {
    const mesh = new THREE.InstancedMesh(geometry, undefined, capacity);
    this.surfaces.cover(mesh, 'robot');
    mesh.count = 0;
    // The robots are nearly always in sight, and a bounding sphere of all of them would have to be made each frame.
    mesh.frustumCulled = false;
    mesh.castShadow = mesh.receiveShadow = true;
    this.parent.add(mesh);
    return mesh;
  }
}
