/** Numbers of a robot that the page can show and plot. */

import { type Contact, type RobotState, rollPitchYaw } from './protocol/frame';
import type { Joint, Pose, RobotClass } from './protocol/scene';
import type { SensorValues } from './protocol/sensors';

export interface Value {
  /** Key of the value, unique within a robot. */
  key: string;
  name: string;
  unit: string;
  digits: number;
  /** True for a number of a sensor: frames of the past do not have it. */
  isReading?: boolean;
  read: (robot: RobotState, sensors: SensorValues) => number | null;
}

/** Names and unit of a value, without the way that it is read. */
export type Shown = Omit<Value, 'read'>;

export interface Group {
  name: string;
  values: Value[];
}

/** Degrees of a radian. */
export const DEGREES = 180 / Math.PI;

/** Lists what every robot has, then its wheels, joints and sensors, as far as these have measured. */
export function valuesOf(robotClass: RobotClass, sensors: SensorValues): Group[] {
  const groups: Group[] = [
    { name: 'Pose', values: POSE },
    { name: 'Velocity', values: VELOCITY },
    { name: 'Wheels', values: robotClass.wheels.flatMap(({ name }, index) => wheelValues(name, index)) },
    { name: 'Joints', values: robotClass.joints.map(jointValue) },
    { name: 'Contacts', values: CONTACTS },
    { name: 'Grip', values: robotClass.wheels.flatMap(({ name }, index) => gripValues(name, index)) },
    { name: 'Slip', values: robotClass.wheels.length > 0 ? slipValues(robotClass) : [] },
    { name: 'Turn', values: robotClass.steering === 'SkidSteered' ? turnValues(robotClass) : [] },
    ...sensorGroups(sensors),
  ];
  return groups.filter(({ values }) => values.length > 0);
}

/** Value that a pose alone gives: of a robot, or of an object. */
export interface PoseValue extends Value {
  read: (of: { pose: Pose }) => number;
}

export const POSE: PoseValue[] = [
  ofPose('x', 'm', 3, ({ pose }) => pose[0]),
  ofPose('y', 'm', 3, ({ pose }) => pose[1]),
  ofPose('z', 'm', 3, ({ pose }) => pose[2]),
  ofPose('roll', '°', 1, ({ pose }) => DEGREES * rollPitchYaw(pose)[0]),
  ofPose('pitch', '°', 1, ({ pose }) => DEGREES * rollPitchYaw(pose)[1]),
  ofPose('yaw', '°', 1, ({ pose }) => DEGREES * rollPitchYaw(pose)[2]),
];

function ofPose(name: string, unit: string, digits: number, read: PoseValue['read']): PoseValue {
  return { key: name, name, unit, digits, read };
}

const VELOCITY: Value[] = [
  value('forward', 'm/s', 3, ({ linear }) => linear[0]),
  value('right', 'm/s', 3, ({ linear }) => linear[1]),
  value('down', 'm/s', 3, ({ linear }) => linear[2]),
  value('clockwise', 'rad/s', 3, ({ angular }) => angular[2]),
];

const CONTACTS: Value[] = [
  value('contacts', '', 0, ({ contacts }) => contacts.length),
  value('force up', 'N', 1, ({ contacts }) => contacts.reduce((sum, { force }) => sum - force[2], 0)),
];

function wheelValues(name: string, index: number): Value[] {
  const of = (key: 'speed' | 'target' | 'angle', unit: string) =>
    value(`${name} ${key}`, unit, 2, ({ wheels }) => wheels[index]?.[key] ?? null, `${key}${index}`);
  return [of('speed', 'rad/s'), of('target', 'rad/s'), of('angle', 'rad')];
}

/** Slip of a wheel's contacts, and their friction over the most that they can give: means by their forces. Null in the air. */
function gripValues(name: string, index: number): Value[] {
  const mean =
    (of: (contact: Contact) => number) =>
    ({ contacts }: RobotState) => {
      const own = contacts
        .filter(({ wheel }) => wheel === index)
        .map((it) => [Math.hypot(...it.force), of(it)] as const);
      const total = own.reduce((sum, [force]) => sum + force, 0);
      return total > 0 ? own.reduce((sum, [force, part]) => sum + force * part, 0) / total : null;
    };
  const slip = mean(({ slip }) => 1000 * Math.hypot(...slip));
  const used = mean(({ share }) => 100 * share);
  return [
    value(`${name} slip`, 'mm/s', 1, slip, `slip${index}`),
    value(`${name} friction`, '%', 0, used, `grip${index}`),
  ];
}

function jointValue({ name, unit = 'rad' }: Joint, index: number): Value {
  return value(name, unit, unit === 'm' ? 4 : 3, ({ joints }) => joints[index]?.position ?? null, `joint${index}`);
}

/** Velocity by the wheels minus that of the robot, by the textbook's kinematics, in which a Mecanum wheel has endlessly many rollers. */
function slipValues({ wheel_radius: radius, steering }: RobotClass): Value[] {
  const byWheels = ({ wheels }: RobotState) => {
    const speeds = wheels.map(({ speed }) => speed);
    const [frontLeft = 0, frontRight = 0, backLeft = 0, backRight = 0] = speeds;
    const forward = (radius * speeds.reduce((sum, speed) => sum + speed, 0)) / Math.max(1, speeds.length);
    const right = steering === 'OmniDrive' ? (radius * (frontLeft - frontRight - backLeft + backRight)) / 4 : 0;
    return [forward, right] as const;
  };
  return [
    value('slip forward', 'mm/s', 1, (robot) => 1000 * (byWheels(robot)[0] - robot.linear[0])),
    value('slip right', 'mm/s', 1, (robot) => 1000 * (byWheels(robot)[1] - robot.linear[1])),
  ];
}

/** Least yaw rate at which a robot turns, rad/s. */
const LEAST_TURN = 0.02;

/** Effective over geometric track (chi): 1 without slip, and more the farther wheels are dragged sideways. Null for a robot that does not turn. */
function turnValues({ wheel_radius: radius, track, wheels }: RobotClass): Value[] {
  const sides = [-1, 1].map((side) =>
    wheels.flatMap(({ link, position }, at) => (link === null && position[1] * side > 0 ? [at] : [])),
  );
  if (track <= 0 || sides.some((side) => side.length === 0) || sides.flat().length < wheels.length) return [];
  const chi = ({ wheels, angular }: RobotState) => {
    const [left, right] = sides.map(
      (side) => side.reduce((sum, at) => sum + (wheels[at]?.speed ?? 0), 0) / side.length,
    );
    return Math.abs(angular[2]) > LEAST_TURN ? (radius * (left! - right!)) / (track * angular[2]) : null;
  };
  return [value('effective / true track', '', 3, chi)];
}

function sensorGroups(sensors: SensorValues): Group[] {
  return [...sensors].map(([sensor, numbers]) => ({
    name: sensor,
    values: [...numbers].map(([key, { unit }]) => ({
      key: `${sensor}/${key}`,
      name: key,
      unit,
      digits: 3,
      isReading: true,
      read: (_: RobotState, now: SensorValues) => now.get(sensor)?.get(key)?.value ?? null,
    })),
  }));
}

function value(name: string, unit: string, digits: number, read: Value['read'], key = name): Value {
  return { key, name, unit, digits, read };
}
