/** All robots of one class, drawn together: one instanced mesh for each part that looks different. */

import * as THREE from 'three';
import type { RobotState } from '../protocol/frame';
import type { Drawn, RobotClass } from '../protocol/scene';
import { Instances } from './instances';
import { setPose } from './pose';
import { solidGeometry } from './solid';
import type { Surfaces } from './surfaces';
import { roller, spoked } from './wheel';

/** A robot so far from the camera has simple rollers, in radii of its wheels. */
const FAR = 45;

/** A part of a robot and where it is. */
export interface Placed {
  part: Instances;
  /** in the world */
  matrix: THREE.Matrix4;
}

export class RobotFleet {
  readonly group = new THREE.Group();
  /** Of the body and the wheels that it carries, in the robot's frame. */
  readonly bounds = new THREE.Box3();
  private readonly body: Instances;
  private readonly links: Instances[];
  /** For each wheel; wheels that look alike share theirs. */
  private readonly wheels: Instances[];
  private readonly rollers: ({ near: Instances; far: Instances; poses: THREE.Matrix4[] } | null)[];
  private readonly all: Set<Instances>;

  constructor(
    readonly robotClass: RobotClass,
    surfaces: Surfaces,
  ) {
    const geometry = ({ shape, pose, colour }: Drawn) => solidGeometry(shape, pose, colour);
    const parts = (geometries: THREE.BufferGeometry[]) => new Instances(this.group, geometries, surfaces);
    const shared = new Map<string, Instances>();
    const share = (look: unknown, make: () => Instances) => {
      const key = JSON.stringify(look);
      const known = shared.get(key) ?? make();
      shared.set(key, known);
      return known;
    };
    const { drawn, links, wheels } = robotClass;
    this.body = parts(drawn.map(geometry));
    this.links = links.map((link) => parts(link.drawn.map(geometry)));
    this.wheels = wheels.map((wheel) => share(wheel.drawn, () => parts(wheel.drawn.map(spoked))));
    this.rollers = wheels.map(({ rollers: known }) => {
      if (!known) return null;
      const { outline, colour, poses } = known;
      const make = (near: boolean) => share([outline, colour, near], () => parts([roller(outline, colour, near)]));
      return { near: make(true), far: make(false), poses: poses.map((pose) => setPose(new THREE.Matrix4(), pose)) };
    });
    this.all = new Set([this.body, ...this.links, ...shared.values()]);
    this.measure();
  }

  /** Puts every robot of the class where it is, as seen from a place in the world. */
  place(robots: RobotState[], eye: THREE.Vector3): void {
    this.all.forEach((part) => part.begin());
    for (const robot of robots) {
      this.parts(robot, eye).forEach(({ part, matrix }) => part.add(matrix));
    }
    this.all.forEach((part) => part.end());
  }

  /** The parts of a robot; without an eye without its rollers. */
  parts(state: RobotState, eye: THREE.Vector3 | null): Placed[] {
    const robot = setPose(new THREE.Matrix4(), state.pose);
    const placed: Placed[] = [{ part: this.body, matrix: robot }];
    const carriers = this.links.map((part, index) => {
      const pose = state.links[index];
      const matrix = pose ? setPose(new THREE.Matrix4(), pose).premultiply(robot) : null;
      if (matrix) placed.push({ part, matrix });
      return matrix;
    });
    const local = new THREE.Matrix4();
    const near = eye && Math.hypot(eye.x - state.pose[0], eye.y - state.pose[1], eye.z - state.pose[2]);
    this.robotClass.wheels.forEach(({ link, position }, index) => {
      const { angle = 0, rollers: angles = [] } = state.wheels[index] ?? {};
      const wheel = ((link !== null && carriers[link]) || robot).clone();
      wheel.multiply(local.makeTranslation(...position)).multiply(local.makeRotationY(-angle));
      const part = this.wheels[index];
      if (part) placed.push({ part, matrix: wheel });
      const rollers = this.rollers[index];
      if (!rollers || near === null) return;
      const roller = near < FAR * this.robotClass.wheel_radius ? rollers.near : rollers.far;
      rollers.poses.forEach((pose, number) => {
        const matrix = new THREE.Matrix4().makeRotationX(angles[number] ?? 0);
        placed.push({ part: roller, matrix: matrix.premultiply(pose).premultiply(wheel) });
      });
    });
    return placed;
  }

  /** How high above its own place a robot reaches, m. */
  height(state: RobotState): number {
    let top = 0;
    const box = new THREE.Box3();
    for (const { part, matrix } of this.parts(state, null)) {
      const own = part.mesh.geometry.boundingBox;
      if (own) top = Math.max(top, state.pose[2] - box.copy(own).applyMatrix4(matrix).min.z);
    }
    return top;
  }

  dispose(): void {
    this.all.forEach((part) => part.dispose());
  }

  private measure(): void {
    this.all.forEach(({ mesh }) => mesh.geometry.attributes.position && mesh.geometry.computeBoundingBox());
    const add = (part: Instances | undefined, x: number, y: number, z: number) => {
      const box = part?.mesh.geometry.boundingBox;
      if (box) this.bounds.union(box.clone().translate(new THREE.Vector3(x, y, z)));
    };
    add(this.body, 0, 0, 0);
    this.robotClass.wheels.forEach(({ link, position }, index) => {
      if (link !== null) return;
      add(this.wheels[index], ...position);
      // Its rollers stand out of it.
      const { wheel_radius: radius } = this.robotClass;
      this.bounds.expandByPoint(new THREE.Vector3(position[0], position[1], position[2] + radius));
    });
    if (this.bounds.isEmpty()) this.bounds.set(new THREE.Vector3(-0.2, -0.2, -0.1), new THREE.Vector3(0.2, 0.2, 0.1));
  }
}
