/** What stands on the map, what can be pushed, its start poses and path nodes. */

import * as THREE from 'three';
import { CSS2DObject } from 'three/addons/renderers/CSS2DRenderer.js';
import type { Pose, Scene } from '../protocol/scene';
import { moveTo } from './pose';
import { merged, solidGeometry } from './solid';

const IDENTITY: Pose = [0, 0, 0, 0, 0, 0, 1];
/** Half the edge of the grid, m. */
const GRID_REACH = 50;
/** Length of the pieces of its lines, m. */
const GRID_PIECE = 5;

export class MapView {
  readonly group = new THREE.Group();
  /** What a robot can be put on. */
  readonly ground: THREE.Mesh;
  readonly grid = new THREE.Group();
  readonly names = new THREE.Group();
  private readonly objects: THREE.Mesh[];
  private readonly material = new THREE.MeshLambertMaterial({
    vertexColors: true,
    // So that the grid lies on the floor and not in it.
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 4,
  });

  constructor({ map }: Scene) {
    const solids = map.solids.map((solid) => solidGeometry(solid.shape, solid.pose, solid.colour));
    this.ground = new THREE.Mesh(merged(solids), this.material);
    this.ground.receiveShadow = this.ground.castShadow = true;
    this.objects = map.objects.map((object) => {
      const mesh = new THREE.Mesh(solidGeometry(object.shape, IDENTITY, object.colour), this.material);
      mesh.castShadow = mesh.receiveShadow = true;
      moveTo(mesh, object.pose);
      const name = label(object.name, 'name object');
      mesh.add(name);
      return mesh;
    });
    for (const { name, position, rotation } of map.starts)
      this.names.add(mark(name, 'name start', position, rotation[2]));
    for (const { name, position } of map.path_nodes) this.names.add(mark(name, 'name node', position, null));
    this.addGrid();
    this.group.add(this.ground, this.grid, this.names, ...this.objects);
  }

  place(poses: Pose[]): void {
    poses.forEach((pose, index) => this.objects[index] && moveTo(this.objects[index], pose));
  }

  showNames(shown: boolean): void {
    this.names.visible = shown;
    this.objects.forEach((object) => object.children.forEach((child) => (child.visible = shown)));
  }

  dispose(): void {
    this.group.traverse((object) => {
      if (object instanceof CSS2DObject) object.element.remove();
      if (object instanceof THREE.Mesh || object instanceof THREE.LineSegments) object.geometry.dispose();
    });
    this.material.dispose();
  }

  /** One metre between lines, every fifth one stronger. */
  private addGrid(): void {
    for (const [step, opacity] of [
      [1, 0.18],
      [5, 0.35],
    ] as const) {
      const corners: number[] = [];
      for (let at = -GRID_REACH; at <= GRID_REACH; at += step) {
        // In pieces: lines that pass behind the camera are drawn badly without a graphics card.
        for (let from = -GRID_REACH; from < GRID_REACH; from += GRID_PIECE) {
          corners.push(at, from, 0, at, from + GRID_PIECE, 0, from, at, 0, from + GRID_PIECE, at, 0);
        }
      }
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.Float32BufferAttribute(corners, 3));
      const material = new THREE.LineBasicMaterial({ color: 0x000000, transparent: true, opacity, depthWrite: false });
      const lines = new THREE.LineSegments(geometry, material);
      // A little above the floor.
      lines.position.z = -0.002;
      this.grid.add(lines);
    }
    for (let at = -GRID_REACH + 10; at < GRID_REACH; at += 10) {
      for (const [x, y, axis] of [
        [at, 0, 'x'],
        [0, at, 'y'],
      ] as const) {
        if (at === 0) continue;
        const name = label(`${axis} ${at} m`, 'name metres');
        name.position.set(x, y, 0);
        this.grid.add(name);
      }
    }
  }
}

/** A place with its name and, where it has one, its direction. */
function mark(name: string, style: string, [x, y, z]: [number, number, number], yaw: number | null): THREE.Object3D {
  const group = new THREE.Group();
  group.position.set(x, y, z);
  const text = label(name, style);
  text.position.z = -0.05;
  group.add(text);
  if (yaw !== null) {
    const arrow = new THREE.BufferGeometry();
    const corners = [0.25, 0, -0.004, -0.1, 0.1, -0.004, -0.1, -0.1, -0.004];
    arrow.setAttribute('position', new THREE.Float32BufferAttribute(corners, 3));
    const material = new THREE.MeshBasicMaterial({
      color: 0x2f7dd1,
      transparent: true,
      opacity: 0.45,
      side: THREE.DoubleSide,
    });
    const mesh = new THREE.Mesh(arrow, material);
    mesh.rotation.z = yaw;
    group.add(mesh);
  }
  return group;
}

export function label(text: string, style: string): CSS2DObject {
  const element = document.createElement('span');
  element.className = style;
  element.textContent = text;
  return new CSS2DObject(element);
}
