/** Lines of the protocol that somebody may want to send, as examples to change. */

import { firstClasses, startsOf } from '../offer';
import { initLine } from '../protocol/client';
import type { RobotClass, Scene } from '../protocol/scene';

/** Returns lines for the driver of a robot of a class, or for somebody without a robot. */
export function suggestions(robotClass: RobotClass | null, scene: Scene | null): string[] {
  if (!robotClass) {
    const classes = scene ? firstClasses(scene) : [];
    const inits = classes.flatMap((name) => {
      const start = scene && startsOf(scene, name)[0];
      return start
        ? [initLine({ robotClass: name, name: 'Typed', place: { start: start.name }, team: start.team })]
        : [];
    });
    return [...inits, 'GETSTARTPOSES'];
  }
  const { joints, grippers } = robotClass;
  return [
    ...drives(robotClass),
    // A place in the upper half of its range, wherever that lies.
    ...joints.map(
      ({ name, min, max }) =>
        `SET {Type Joint} {Name ${name}} {Opcode Angle} {Params ${((min + 3 * max) / 4).toFixed(2)}}`,
    ),
    ...grippers.flatMap(({ name }) =>
      ['Open', 'Close'].map((way) => `SET {Type Gripper} {Name ${name}} {Opcode ${way}}`),
    ),
    'GETCONF {Type Robot}',
    'GETGEO {Type Robot}',
    'GETSTARTPOSES',
    'REPORT {Errors true}',
  ];
}

function drives({ steering }: RobotClass): string[] {
  switch (steering) {
    case 'SkidSteered':
      return ['DRIVE {Left 2} {Right 2}', 'DRIVE {Left -1} {Right 1}', 'DRIVE {Left 0} {Right 0}'];
    case 'OmniDrive':
      return [
        'DRIVE {LinearVelocity 0.3} {LateralVelocity 0} {RotationalVelocity 0}',
        'DRIVE {LinearVelocity 0} {LateralVelocity 0.3} {RotationalVelocity 0}',
        'DRIVE {LinearVelocity 0} {LateralVelocity 0} {RotationalVelocity 0}',
      ];
    case 'AckermanSteered':
      return ['DRIVE {Speed 5} {FrontSteer 0.2} {RearSteer 0}', 'DRIVE {Speed 0} {FrontSteer 0} {RearSteer 0}'];
    case 'Aerial':
      return [
        'DRIVE {AltitudeVelocity 0.5} {LinearVelocity 0} {LateralVelocity 0} {RotationalVelocity 0}',
        'DRIVE {AltitudeVelocity 0} {LinearVelocity 0.5} {LateralVelocity 0} {RotationalVelocity 0}',
      ];
    case 'Legged':
    case 'None':
      return [];
  }
}
