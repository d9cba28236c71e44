/** State of the world that the page shows: the server's, or a log's. */

import type { Frame, RobotState } from './protocol/frame';
import type { Known } from './playback';
import type { Status } from './protocol/live';
import type { Pose, RobotClass, Scene, Solid } from './protocol/scene';
import { bodyColour, colourOf } from './view/colours';
import { type Reading, type SensorValues, addReading } from './protocol/sensors';

export class State {
  scene: Scene | null = null;
  status: Status | null = null;
  frame: Frame | null = null;
  /** Objects that the map does not have, by their numbers; also some that have been removed. */
  spawned: ReadonlyMap<number, Solid> = new Map();
  /** Robots that are or were in the world, by their numbers. */
  met: ReadonlyMap<number, Known> = new Map();
  /** Number of the robot that is looked at. */
  selected: number | null = null;
  /** Number of the object that is chosen in place of the robot. */
  chosenObject: number | null = null;
  /** True if the map is chosen in place of a robot or an object. */
  isMapChosen = false;
  /** The server's numbers of this page's own connections, which have spawned a robot each. */
  readonly own = new Set<number>();
  /** INIT lines that this page has sent. */
  readonly ownInits = new Set<string>();
  /** True while the page shows the server's present, not the past and not a log. */
  isPresent = true;
  /** True if this page has a robot to drive. */
  hasRobot = false;
  /** True while a program of this page drives robots. */
  isProgrammed = false;
  private readonly sensors = new Map<number, SensorValues>();

  /** True if nobody can drive here: a program steps the world, and the page shows it. */
  get isWatched(): boolean {
    return this.scene?.port === 0;
  }

  /** True if a robot is driven from this page: it gets the keys. */
  get driving(): boolean {
    return this.hasRobot && this.isPresent;
  }

  /** A robot that is in the world. */
  robot(id: number | null): Status['robots'][number] | null {
    return this.status?.robots.find((robot) => robot.id === id) ?? null;
  }

  /** Class and name of a robot, also of one that has left. */
  known(id: number | null): Known | null {
    return this.robot(id) ?? (id === null ? null : (this.met.get(id) ?? null));
  }

  classOf(id: number | null): RobotClass | null {
    const robot = this.known(id);
    return (robot && this.scene?.classes[robot.class]) ?? null;
  }

  robotState(id: number | null): RobotState | null {
    return this.frame?.robots.find((robot) => robot.id === id) ?? null;
  }

  /** Returns a movable object; null before the server has sent it. */
  object(number: number): Solid | null {
    return this.scene?.map.objects[number] ?? this.spawned.get(number) ?? null;
  }

  /** Pose of an object; null if it is not there. */
  objectPose(number: number | null): Pose | null {
    return this.frame?.objects.find((object) => object.number === number)?.pose ?? null;
  }

  /** Numbers of the objects that are there. */
  get objects(): number[] {
    const numbers = this.frame?.objects.map(({ number }) => number) ?? [...(this.scene?.map.objects.keys() ?? [])];
    return numbers.filter((number) => this.object(number));
  }

  /** The last readings of a robot's sensors, as far as they were listened to. */
  sensorsOf(id: number): SensorValues {
    let values = this.sensors.get(id);
    if (!values) this.sensors.set(id, (values = new Map()));
    return values;
  }

  takeReading(reading: Reading): void {
    const name = this.classOf(reading.robot)?.sensors[reading.sensor]?.name;
    if (name !== undefined) addReading(reading, name, this.sensorsOf(reading.robot));
  }

  /** Forgets all readings, because a fresh world begins. */
  forgetSensors(): void {
    this.sensors.clear();
  }

  isOwn({ connection }: Status['robots'][number]): boolean {
    return connection !== null && this.own.has(connection);
  }

  /** Robots that others have spawned. */
  othersRobots(): Status['robots'] {
    return (this.status?.robots ?? []).filter((robot) => !this.isOwn(robot));
  }

  /** A robot's colour, which goes by its name and is unlike its body. */
  colourOf(id: number): string {
    const robotClass = this.classOf(id);
    return colourOf({ id, name: this.known(id)?.name ?? '' }, robotClass && bodyColour(robotClass));
  }

  /** A robot's name for people. */
  nameOf(id: number): string {
    const robot = this.known(id);
    return robot?.name || `${robot?.class ?? 'robot'} #${id}`;
  }
}
