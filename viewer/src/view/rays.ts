/** Fields of view of a robot's sensors: a faint fan for a laser, a cone for a sonar. */

import * as THREE from 'three';

/** Opening of a sonar's cone, rad: USARSim's own, since the scene says nothing. */
const CONE = 0.349;
const CONE_CORNERS = 20;

/** A fan from the origin to places, all in the world. */
export function fanGeometry(origin: THREE.Vector3, places: Float32Array): THREE.BufferGeometry {
  const corners: number[] = [];
  for (let at = 0; at + 5 < places.length; at += 3) corners.push(...origin, ...places.subarray(at, at + 6));
  return new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute(corners, 3));
}

/** A cone along the x axis of a sensor. */
export function coneGeometry(mount: THREE.Matrix4, range: number): THREE.BufferGeometry {
  const height = range * Math.cos(CONE / 2);
  const cone = new THREE.ConeGeometry(range * Math.sin(CONE / 2), height, CONE_CORNERS, 1, true);
  // Its tip is at the top of the y axis, half its height above the middle.
  return cone
    .translate(0, -height / 2, 0)
    .rotateZ(Math.PI / 2)
    .applyMatrix4(mount);
}

export class Rays {
  readonly group = new THREE.Group();
  private readonly meshes = new Map<string, THREE.Mesh>();
  private readonly materials = new Map<number, THREE.Material>();

  set(key: string, geometry: THREE.BufferGeometry, colour: THREE.Color): void {
    this.remove(key);
    const mesh = new THREE.Mesh(geometry, this.material(colour));
    mesh.frustumCulled = false;
    mesh.renderOrder = 5;
    this.meshes.set(key, mesh);
    this.group.add(mesh);
  }

  remove(key: string): void {
    const mesh = this.meshes.get(key);
    if (!mesh) return;
    mesh.geometry.dispose();
    this.group.remove(mesh);
    this.meshes.delete(key);
  }

  clear(): void {
    [...this.meshes.keys()].forEach((key) => this.remove(key));
  }

  dispose(): void {
    this.clear();
    this.materials.forEach((material) => material.dispose());
  }

  private material(colour: THREE.Color): THREE.Material {
    const key = colour.getHex();
    const known = this.materials.get(key);
    if (known) return known;
    const material = new THREE.MeshBasicMaterial({
      color: colour,
      transparent: true,
      opacity: 0.13,
      side: THREE.DoubleSide,
      depthWrite: false,
      fog: false,
    });
    this.materials.set(key, material);
    return material;
  }
}
