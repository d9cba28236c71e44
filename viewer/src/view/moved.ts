/** Comparison of two frames: true if something visible differs. */

import type { Frame, ObjectState, Pull, RobotState } from '../protocol/frame';

/** Less is not seen: m and parts of a quaternion; rad of a wheel. */
const LEAST_MOVE = 5e-5;
const LEAST_TURN = 2e-3;

/** Motions that count. */
export interface Counted {
  /** Forces where robots touch something: they change all the time. */
  forces: boolean;
  /** Free rollers' own: they turn for seconds after their robot has stopped. */
  rollers: boolean;
}

export function moved(before: Frame, after: Frame, counted: Counted): boolean {
  if (before.robots.length !== after.robots.length) return true;
  if (objectsDiffer(before.objects, after.objects)) return true;
  if (differ(before.pulls.map(numbersOf), after.pulls.map(numbersOf))) return true;
  return after.robots.some((robot, index) => {
    const last = before.robots[index];
    if (!last || last.id !== robot.id || (counted.forces && robot.contacts.length > 0)) return true;
    return robotMoved(last, robot, counted.rollers);
  });
}

function robotMoved(before: RobotState, after: RobotState, withRollers: boolean): boolean {
  if (differ([before.pose], [after.pose]) || differ(before.links, after.links)) return true;
  return after.wheels.some(({ angle, rollers }, index) => {
    const last = before.wheels[index];
    if (!last || Math.abs(last.angle - angle) > LEAST_TURN) return true;
    return withRollers && rollers.some((turn, number) => Math.abs(turn - (last.rollers[number] ?? 0)) > 4 * LEAST_TURN);
  });
}

function objectsDiffer(before: ObjectState[], after: ObjectState[]): boolean {
  if (after.some(({ number }, index) => number !== before[index]?.number)) return true;
  const poses = (objects: ObjectState[]) => objects.map(({ pose }) => pose);
  return differ(poses(before), poses(after));
}

/** Numbers of a pull, its force in a unit in which half of the digit that is shown is LEAST_MOVE. */
function numbersOf({ from, to, force }: Pull): number[] {
  return [...from, ...to, (force / 0.05) * LEAST_MOVE];
}

function differ(before: number[][], after: number[][]): boolean {
  if (before.length !== after.length) return true;
  return after.some((pose, index) =>
    pose.some((value, part) => Math.abs(value - (before[index]?.[part] ?? 0)) > LEAST_MOVE),
  );
}
