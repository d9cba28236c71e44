/** Arms: the positions of joints that bring a point of a link to a place. Frames are those of the class: the robot's, z down. */

import * as THREE from 'three';
import type { RobotClass, Vector } from './protocol/scene';

/** Place and direction that a point of a link shall have. */
export interface Reach {
  /** Index among the class's links. */
  link: number;
  /** Point in the link's frame, m. */
  grip: Vector;
  /** Place in the robot's frame, m. */
  to: Vector;
  /** Orientation of the link in the robot's frame; it counts less than the place. */
  facing: THREE.Quaternion | null;
}

/** Positions of the class's joints, in its order, and what is left of the way, m, and of the turn, rad. */
export interface Reached {
  positions: number[];
  way: number;
  turn: number;
}

/** Way that weighs as much as a turn of 1 rad, m. */
const TURN_WEIGHT = 0.15;
/** Damping of the least squares, m: more is slower, less swings where the arm is stretched. */
const DAMPING = 0.02;
/** Rounds with the orientation, then rounds for the place alone. */
const ROUNDS = [80, 30] as const;
/** Most that a joint moves in a round, rad or m. */
const MOST = 0.3;
/** Nearer than this is there, m. */
const NEAR = 1e-4;
/** Height of the gripper above the floor to pick something up, m. */
const PICK_HEIGHT = 0.03;
/** Left of a pose's way, m, and turn, rad, at most. */
const FITS = { way: 0.005, turn: 0.1 };

/** Parts of the arm's reach that a pose tries: ahead of the arm's base, and above it to carry something. */
const SHARES = [0.5, 0.45, 0.4, 0.55, 0.35, 0.6, 0.3, 0.25, 0.7];
const CARRY_HEIGHTS = [0.2, 0.1, 0, -0.1, -0.2];

/** A joint between the body and the link that is moved. */
interface Mover {
  /** Index among the class's joints. */
  joint: number;
  link: number;
  axis: THREE.Vector3;
  slides: boolean;
}

/** Returns the joints that move a link by their positions, from the body outward. Fingers only grip. */
export function moversOf(robotClass: RobotClass, link: number): Mover[] {
  const fingers = new Set(robotClass.grippers.flatMap(({ joints }) => joints));
  const movers: Mover[] = [];
  for (let at: number | null = link; at !== null; at = robotClass.links[at]?.parent ?? null) {
    const { name } = robotClass.links[at] ?? {};
    const number = robotClass.joints.findIndex((joint) => joint.name === name);
    const joint = robotClass.joints[number];
    if (!joint || fingers.has(joint.name)) continue;
    movers.unshift({ joint: number, link: at, axis: new THREE.Vector3(...joint.axis), slides: joint.unit === 'm' });
  }
  return movers;
}

/** Returns the poses of the links in the robot's frame, with every joint of the class at a position. */
function placed(robotClass: RobotClass, positions: readonly number[]): THREE.Matrix4[] {
  const matrices: THREE.Matrix4[] = [];
  robotClass.links.forEach(({ name, parent, pose }, index) => {
    const from = parent === null ? null : robotClass.links[parent];
    const [x = 0, y = 0, z = 0] = from?.pose ?? [];
    // With every joint at 0 all frames are parallel to the robot's.
    const matrix = new THREE.Matrix4().makeTranslation(pose[0] - x, pose[1] - y, pose[2] - z);
    const number = robotClass.joints.findIndex((joint) => joint.name === name);
    const joint = robotClass.joints[number];
    if (joint) {
      const axis = new THREE.Vector3(...joint.axis);
      const value = positions[number] ?? 0;
      const way = axis.clone().multiplyScalar(value);
      const motion = new THREE.Matrix4();
      matrix.multiply(joint.unit === 'm' ? motion.setPosition(way) : motion.makeRotationAxis(axis, value));
    }
    const carrier = parent === null ? null : matrices[parent];
    matrices[index] = carrier ? matrix.premultiply(carrier) : matrix;
  });
  return matrices;
}

/** Finds positions near the given ones by damped least squares on the Jacobian, within the joints' limits. */
export function reach(robotClass: RobotClass, from: readonly number[], wish: Reach): Reached {
  const movers = moversOf(robotClass, wish.link);
  let best: Reached = { positions: [...from], way: Infinity, turn: Infinity };
  let positions = [...from];
  ROUNDS.forEach((rounds, phase) => {
    const weight = wish.facing && phase === 0 ? TURN_WEIGHT : 0;
    let least = Infinity;
    for (let round = 0; round < rounds; round++) {
      const { point, error, axes, origins } = look(robotClass, movers, positions, wish);
      const [way, turn] = [Math.hypot(...error.slice(0, 3)), Math.hypot(...error.slice(3))];
      const left = Math.hypot(way, weight * turn);
      if (left < least) {
        least = left;
        best = { positions: [...positions], way, turn };
      }
      if (left < NEAR) break;
      positions = step(robotClass, movers, positions, { point, error, axes, origins, weight });
    }
    positions = [...best.positions];
  });
  return best;
}

interface Look {
  /** Point that shall move. */
  point: THREE.Vector3;
  /** Way that is left, m, and turn about each axis, rad. */
  error: number[];
  /** Axes of the joints, and points on them. */
  axes: THREE.Vector3[];
  origins: THREE.Vector3[];
}

function look(robotClass: RobotClass, movers: Mover[], positions: number[], wish: Reach): Look {
  const matrices = placed(robotClass, positions);
  const matrix = matrices[wish.link] ?? new THREE.Matrix4();
  const point = new THREE.Vector3(...wish.grip).applyMatrix4(matrix);
  const way = new THREE.Vector3(...wish.to).sub(point);
  const turn = wish.facing ? turnBetween(new THREE.Quaternion().setFromRotationMatrix(matrix), wish.facing) : null;
  const of = (link: number) => matrices[link] ?? new THREE.Matrix4();
  return {
    point,
    error: [...way, ...(turn ?? [0, 0, 0])],
    axes: movers.map(({ link, axis }) => axis.clone().transformDirection(of(link))),
    origins: movers.map(({ link }) => new THREE.Vector3().setFromMatrixPosition(of(link))),
  };
}

/** Returns the turn from one orientation to another: an axis times an angle, rad. */
function turnBetween(from: THREE.Quaternion, to: THREE.Quaternion): THREE.Vector3 {
  const { x, y, z, w } = to.clone().multiply(from.clone().conjugate());
  const axis = new THREE.Vector3(x, y, z);
  const angle = 2 * Math.atan2(axis.length(), Math.abs(w));
  return axis.setLength(w < 0 ? -angle : angle);
}

/** Returns positions a step nearer. A joint that would leave its limits rests, and the others do its part. */
function step(
  robotClass: RobotClass,
  movers: Mover[],
  positions: number[],
  { point, error, axes, origins, weight }: Look & { weight: number },
): number[] {
  const resting = new Set<number>();
  for (;;) {
    const columns = movers.map(({ slides }, index) => {
      const axis = axes[index]!;
      if (resting.has(index)) return [0, 0, 0, 0, 0, 0];
      if (slides) return [...axis, 0, 0, 0];
      const lever = axis.clone().cross(point.clone().sub(origins[index]!));
      return [...lever, ...axis.clone().multiplyScalar(weight)];
    });
    const wanted = error.map((part, row) => (row < 3 ? part : weight * part));
    const squares = wanted.map((_, row) =>
      wanted.map((_, other) => {
        const sum = columns.reduce((sum, column) => sum + column[row]! * column[other]!, 0);
        return row === other ? sum + DAMPING ** 2 : sum;
      }),
    );
    const solved = solve(squares, wanted);
    const changes = columns.map((column) => column.reduce((sum, part, row) => sum + part * solved[row]!, 0));
    const most = Math.max(MOST, ...changes.map(Math.abs));
    const next = [...positions];
    const before = resting.size;
    movers.forEach(({ joint }, index) => {
      const { min, max } = robotClass.joints[joint]!;
      const value = positions[joint]! + (changes[index]! * MOST) / most;
      next[joint] = Math.max(min, Math.min(max, value));
      const isAtEnd = positions[joint]! <= min || positions[joint]! >= max;
      if (isAtEnd && next[joint] === positions[joint] && changes[index] !== 0) resting.add(index);
    });
    if (resting.size === before) return next;
  }
}

/** Solves a symmetric positive definite system by elimination. */
function solve(rows: number[][], right: number[]): number[] {
  const matrix = rows.map((row, index) => [...row, right[index]!]);
  matrix.forEach((pivot, at) => {
    for (const row of matrix.slice(at + 1)) {
      const factor = row[at]! / pivot[at]!;
      pivot.forEach((part, column) => (row[column]! -= factor * part));
    }
  });
  const solution: number[] = [];
  for (let at = matrix.length - 1; at >= 0; at--) {
    const row = matrix[at]!;
    const known = solution.reduce((sum, value, index) => sum + value * row[matrix.length - 1 - index]!, 0);
    solution.push((row[matrix.length]! - known) / row[at]!);
  }
  return solution.reverse();
}

/** Returns positions in the middle of all joints: an arm that is stretched may find no way from where it is, but from there. */
export function middlesOf({ joints }: RobotClass): number[] {
  return joints.map(({ min, max }) => (min + max) / 2);
}

/** Finds positions that bring the gripper to a place of the robot's frame, fingers down, from the best start; null without a gripper on an arm. */
export function reachToGrip(robotClass: RobotClass, starts: readonly number[][], to: Vector): Reached | null {
  const [{ link, middle } = { link: null, middle: to }] = robotClass.grippers;
  if (link === null || moversOf(robotClass, link).length === 0) return null;
  // The fingers point away from their carrier's joint.
  const angle = -Math.atan2(middle[0], middle[2]);
  const facing = new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(0, 1, 0), angle);
  const left = ({ way, turn }: Reached) => Math.hypot(way, TURN_WEIGHT * turn);
  let best: Reached | null = null;
  for (const start of starts) {
    const reached = reach(robotClass, start, { link, grip: middle, to, facing });
    if (!best || left(reached) < left(best) - NEAR) best = reached;
    if (left(best) <= NEAR) break;
  }
  return best;
}

/** Returns positions that bring the gripper so far from where positions have it, m, along the robot's axes and turned as it is; null out of reach. */
export function nudged(robotClass: RobotClass, positions: readonly number[], by: Vector): number[] | null {
  const [gripper] = robotClass.grippers;
  if (gripper?.link == null) return null;
  const matrix = placed(robotClass, positions)[gripper.link] ?? new THREE.Matrix4();
  const place = new THREE.Vector3(...gripper.middle).applyMatrix4(matrix).add(new THREE.Vector3(...by));
  const facing = new THREE.Quaternion().setFromRotationMatrix(matrix);
  const wish = { link: gripper.link, grip: gripper.middle, to: place.toArray(), facing };
  const reached = reach(robotClass, positions, wish);
  return reached.way < FITS.way ? reached.positions : null;
}

/** Poses of a gripper; null for what the arm does not reach. */
interface GripPoses {
  /** Just above the floor ahead, to pick something up. */
  pick: number[] | null;
  carry: number[] | null;
}

const posesOfClasses = new WeakMap<RobotClass, GripPoses>();

/** Returns the poses of a class's gripper. They are found once, which takes some hundredths of a second. */
export function gripPoses(robotClass: RobotClass): GripPoses {
  const poses = posesOfClasses.get(robotClass) ?? findGripPoses(robotClass);
  posesOfClasses.set(robotClass, poses);
  return poses;
}

function findGripPoses(robotClass: RobotClass): GripPoses {
  const [gripper] = robotClass.grippers;
  const movers = gripper?.link != null ? moversOf(robotClass, gripper.link) : [];
  const floor = floorOf(robotClass);
  const origins = movers.map(({ link }) => new THREE.Vector3(...robotClass.links[link]!.pose.slice(0, 3)));
  const [base] = origins;
  if (!gripper || !base || floor === null) return { pick: null, carry: null };
  const length = origins.reduce((sum, origin, index) => sum + origin.distanceTo(origins[index + 1] ?? origin), 0);
  const reachable = length + Math.hypot(...gripper.middle);
  const starts = [middlesOf(robotClass)];
  const find = (heights: number[]) => {
    for (const height of heights) {
      for (const share of SHARES) {
        const reached = reachToGrip(robotClass, starts, [base.x + share * reachable, base.y, height]);
        if (reached && reached.way < FITS.way && reached.turn < FITS.turn) return reached.positions;
      }
    }
    return null;
  };
  return {
    pick: find([floor - PICK_HEIGHT]),
    carry: find(CARRY_HEIGHTS.map((share) => base.z - share * reachable)),
  };
}

/** Height of the floor under a robot on wheels in its own frame, m; null without wheels. */
export function floorOf({ wheels, links, wheel_radius: radius }: RobotClass): number | null {
  const heights = wheels.map(({ link, position }) => position[2] + (link === null ? 0 : (links[link]?.pose[2] ?? 0)));
  return heights.length > 0 ? Math.max(...heights) + radius : null;
}
