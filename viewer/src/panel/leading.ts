/** A hand on a robot's arm: its joints follow a link that is dragged. They go where their own motors bring them. */

import * as THREE from 'three';
import { type Reach, moversOf, reach } from '../arm';
import type { RobotClass, Vector } from '../protocol/scene';
import type { State } from '../state';
import { ownPoint, worldPoint } from '../view/pose';
import type { Led } from '../view/pulls';
import type { Hit } from '../view/view';
import { TURN } from './hands';

interface Taken {
  robot: number;
  robotClass: RobotClass;
  wish: Reach & { facing: THREE.Quaternion };
  /** Orientation of the link when it was taken. */
  facing: THREE.Quaternion;
  /** Positions of the class's joints that were asked for. */
  positions: number[];
  /** Place of the world to which it is led. */
  to: Vector | null;
}

export class Leading {
  private taken: Taken | null = null;

  constructor(
    private readonly state: State,
    /** Moves joints of the driven robot to positions, by their names. */
    private readonly moveJoints: (positions: ReadonlyMap<string, number>) => void,
    /** Shows the way to the hand; null for none. */
    private readonly show: (led: Led | null) => void,
  ) {}

  get isOn(): boolean {
    return this.taken !== null;
  }

  /** Takes a link that joints of this page's own robot move. Returns false for all else, and while time stands still. */
  take(hit: Hit): boolean {
    if (!('robot' in hit) || hit.link === null) return false;
    const { robot: id, link, place } = hit;
    const { state } = this;
    const [robot, robotClass, shown] = [state.robot(id), state.classOf(id), state.robotState(id)];
    const pose = shown?.links[link];
    if (!robot || !robotClass || !shown || !pose || !state.isPresent || state.status?.paused) return false;
    if (!state.isOwn(robot) || moversOf(robotClass, link).length === 0) return false;
    const to = ownPoint(shown.pose, place);
    const [, , , x, y, z, w] = pose;
    const facing = new THREE.Quaternion(x, y, z, w);
    const wish = { link, grip: ownPoint(pose, to), to, facing: facing.clone() };
    this.taken = {
      robot: id,
      robotClass,
      wish,
      facing,
      positions: shown.joints.map(({ position }) => position),
      to: null,
    };
    return true;
  }

  /** Leads the link to a place of the world; `turn` is a way of the pointer that turns it about the robot's vertical, px. */
  lead(to: Vector, turn: number): void {
    if (!this.taken) return;
    const { robot, robotClass, wish, facing } = this.taken;
    const shown = this.state.robotState(robot);
    if (!shown) return this.release();
    wish.to = ownPoint(shown.pose, to);
    wish.facing.setFromAxisAngle(new THREE.Vector3(0, 0, 1), TURN * turn).multiply(facing);
    const { positions } = reach(robotClass, this.taken.positions, wish);
    const moved = moversOf(robotClass, wish.link).map(({ joint }) => joint);
    this.moveJoints(new Map(moved.map((joint) => [robotClass.joints[joint]!.name, positions[joint]!])));
    Object.assign(this.taken, { positions, to });
    this.follow();
  }

  /** Shows the way that is left, in the frame that is shown. */
  follow(): void {
    if (!this.taken?.to) return;
    const { robot, wish, to } = this.taken;
    const shown = this.state.robotState(robot);
    const pose = shown?.links[wish.link];
    if (shown && pose) this.show({ from: worldPoint(shown.pose, worldPoint(pose, wish.grip)), to });
  }

  release(): void {
    if (this.taken) this.show(null);
    this.taken = null;
  }
}
