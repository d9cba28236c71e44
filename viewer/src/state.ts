/** What the page knows of the world. */

import type { Frame, RobotState } from './protocol/frame';
import type { Status } from './protocol/live';
import type { RobotClass, Scene } from './protocol/scene';

export class State {
  scene: Scene | null = null;
  status: Status | null = null;
  frame: Frame | null = null;
  /** Number of the robot that is looked at. */
  selected: number | null = null;
  /** Whether a robot is driven from this page: it gets the keys. */
  driving = false;

  /** Class and name of a robot. */
  robot(id: number | null): Status['robots'][number] | null {
    return this.status?.robots.find((robot) => robot.id === id) ?? null;
  }

  classOf(id: number | null): RobotClass | null {
    const robot = this.robot(id);
    return (robot && this.scene?.classes[robot.class]) ?? null;
  }

  robotState(id: number | null): RobotState | null {
    return this.frame?.robots.find((robot) => robot.id === id) ?? null;
  }
}
