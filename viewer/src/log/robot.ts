/** A robot of a log in the shape that a live world gives. */

import type { RobotState } from '../protocol/frame';
import type { Pose, RobotClass, Vector } from '../protocol/scene';
import type { StateMessage } from './messages';

type JointState = RobotState['joints'][number];

/**
 * Returns the state of a robot in a log. It has no targets of wheels, which repeat their speeds, no angles of rollers, which are 0, and no
 * contacts. `transforms` are poses of links in the robot frame by `FRAME/LINK`; old logs have none of casters.
 */
export function robotState(
  state: StateMessage,
  robotClass: RobotClass,
  frame: string,
  transforms: Map<string, Pose>,
): RobotState {
  const joints = valuesOf(state, robotClass);
  const wheels = robotClass.wheels.map(({ name, rollers }) => {
    const { position, speed } = joints.get(name) ?? { position: 0, speed: 0 };
    return { angle: position, speed, target: speed, rollers: (rollers?.poses ?? []).map(() => 0) };
  });
  return {
    id: state.robot,
    pose: state.pose,
    linear: intoRobot(state.pose, state.linear),
    angular: intoRobot(state.pose, state.angular),
    wheels,
    links: robotClass.links.map(({ name, pose }) => transforms.get(`${frame}/${name}`) ?? pose),
    joints: jointStates(state, robotClass),
    contacts: [],
  };
}

/** The joints that the class's `joints` lists, in its order. */
export function jointStates(state: StateMessage, robotClass: RobotClass): JointState[] {
  const joints = valuesOf(state, robotClass);
  return robotClass.joints.map(({ name }) => joints.get(name) ?? { position: 0, speed: 0 });
}

function valuesOf({ positions, speeds }: StateMessage, { values }: RobotClass): Map<string, JointState> {
  return new Map(values.map((name, at) => [name, { position: positions[at] ?? 0, speed: speeds[at] ?? 0 }]));
}

/** A vector of the world along the axes of a pose. */
export function intoRobot([, , , qx, qy, qz, w]: Pose, vector: Vector): Vector {
  // v + 2 u x (u x v + w v) with the inverse's u.
  const [x, y, z] = [-qx, -qy, -qz];
  const cross = ([a, b, c]: Vector): Vector => [y * c - z * b, z * a - x * c, x * b - y * a];
  const once = cross(vector);
  const twice = cross([once[0] + w * vector[0], once[1] + w * vector[1], once[2] + w * vector[2]]);
  return [vector[0] + 2 * twice[0], vector[1] + 2 * twice[1], vector[2] + 2 * twice[2]];
}
