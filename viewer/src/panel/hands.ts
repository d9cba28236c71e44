/** Hands in the world: a drag pulls a thing by a spring, or moves it while time stands still. All goes over the wire. */

import type { Pose, Vector } from '../protocol/scene';
import { rollPitchYaw } from '../protocol/frame';
import type { State } from '../state';
import { ownPoint } from '../view/pose';
import { spawnPlace } from './spawn';

/** Objects that are put on the floor: the server's classes, with lengths and heights, m. */
export const OBJECTS = [
  { name: 'a crate', objectClass: 'WCCrate', length: 0.5, height: 0.5 },
  { name: 'a blue crate', objectClass: 'WCCrateBlue', length: 0.5, height: 0.5 },
  { name: 'a pallet', objectClass: 'WCPallet', length: 1.2, height: 0.144 },
] as const;
/** Room between an object and its copy, m. */
const ROOM = 0.1;

/** Robot or object that somebody takes. */
export type Thing = { robot: number } | { object: number };

/** Least time between two lines, ms. */
const INTERVAL = 40;
/** Turn for a pixel, rad. */
export const TURN = 0.01;

/** The thing in the hand, as it was taken. */
interface Taken {
  thing: Thing;
  name: string;
  pose: Pose;
  /** Place that was taken. */
  place: Vector;
  /** Point that was taken in the thing's own frame. */
  grip: Vector;
  isPaused: boolean;
  /** True once a spring pulls it. */
  isPulled: boolean;
}

export class Hands {
  private taken: Taken | null = null;
  private next: string | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly state: State,
    /** Sends a line of a world controller. */
    private readonly send: (line: string) => void,
    /** Returns the reason why this page may change nothing in the world; null if it may. */
    private readonly refused: () => string | null,
  ) {}

  /** True if this page may change what is in the world that it shows. */
  get mayAct(): boolean {
    return this.state.isPresent && this.refused() === null;
  }

  /** The robot or object that is chosen. */
  get chosen(): Thing | null {
    const { chosenObject: object, selected: robot } = this.state;
    if (object !== null) return { object };
    return robot === null ? null : { robot };
  }

  /** True if a thing is the chosen one. */
  isChosen(thing: Thing): boolean {
    return this.chosen !== null && isSame(thing, this.chosen);
  }

  /** True if a thing is in the hand. */
  holds(thing: Thing): boolean {
    return this.taken !== null && isSame(thing, this.taken.thing);
  }

  /** Returns the place of a thing. */
  placeOf(thing: Thing): Vector | null {
    const pose = this.poseOf(thing);
    return pose && [pose[0], pose[1], pose[2]];
  }

  /** Takes a thing at a place of the world, and lets go of what is in the hand. Returns false if it is not there, or this page may not. */
  take(thing: Thing, place: Vector): boolean {
    if (!this.mayAct) return false;
    this.release();
    const pose = this.poseOf(thing);
    const name = this.nameOf(thing);
    if (!pose || name === null) return false;
    const isPaused = this.state.status?.paused === true;
    this.taken = { thing, name, pose, place, grip: ownPoint(pose, place), isPaused, isPulled: false };
    return true;
  }

  /** Pulls to a place; `turn` is a way of the pointer that turns about the vertical, px. */
  pull(to: Vector, turn: number): void {
    if (!this.taken) return;
    const { name, pose, place, grip, isPaused } = this.taken;
    const [roll, pitch, yaw] = rollPitchYaw(pose);
    const rotation = `{Rotation ${numbers([roll, pitch, yaw + TURN * turn])}}`;
    if (isPaused) {
      const at: Vector = [0, 1, 2].map((axis) => (pose[axis] ?? 0) + (to[axis] ?? 0) - (place[axis] ?? 0)) as Vector;
      return this.say(`CONTROL {Type AbsMove} {Name ${name}} {Location ${numbers(at)}} ${rotation}`);
    }
    this.taken.isPulled = true;
    const line = `CONTROL {Type Pull} {Name ${name}} {Grip ${numbers(grip)}} {Location ${numbers(to)}}`;
    this.say(turn === 0 ? line : `${line} ${rotation}`);
  }

  /** Puts a robot down on the floor at a place, upright, with its heading. */
  putDown(place: Vector): void {
    if (!this.taken) return;
    const { name, pose } = this.taken;
    // Somebody has stopped time while it was pulled.
    this.release();
    const at = `{Location ${numbers(spawnPlace(place))}} {Rotation ${numbers([0, 0, rollPitchYaw(pose)[2]])}}`;
    this.send(`CONTROL {Type AbsMove} {Name ${name}} ${at}`);
  }

  /** Lets go. */
  release(): void {
    if (!this.taken) return;
    const { name, isPulled } = this.taken;
    this.taken = null;
    this.flush();
    if (isPulled) this.send(`CONTROL {Type Pull} {Name ${name}}`);
  }

  /** Puts a crate or another object of a class at a place of the floor. */
  put(objectClass: string, height: number, [x, y, z]: Vector): void {
    const names = new Set(this.state.objects.map((number) => this.state.object(number)?.name));
    let count = 1;
    while (names.has(`${objectClass}-${count}`)) count++;
    const what = `{ClassName ${objectClass}} {Name ${objectClass}-${count}}`;
    const where = `{Location ${numbers(spawnPlace([x, y, z - height / 2]))}}`;
    this.send(`CONTROL {Type Create} ${what} ${where} {Physics RigidBody} {Permanent true}`);
  }

  /** True if another object like this one can be put: it has the name of its class, as those that the menu puts. */
  canCopy(object: number): boolean {
    return this.kindOf(object) !== undefined;
  }

  /** Puts an object of the same class beside an object. */
  copy(object: number): void {
    const [kind, pose] = [this.kindOf(object), this.state.objectPose(object)];
    if (!kind || !pose) return;
    const [x, y, z] = pose;
    this.put(kind.objectClass, kind.height, [x + kind.length + ROOM, y, z + kind.height / 2]);
  }

  private kindOf(object: number): (typeof OBJECTS)[number] | undefined {
    const [objectClass] = (this.state.object(object)?.name ?? '').split('-');
    return OBJECTS.find((kind) => kind.objectClass === objectClass);
  }

  /** Removes an object. */
  remove(object: number): void {
    const name = this.nameOf({ object });
    if (name !== null) this.send(`CONTROL {Type Kill} {Name ${name}}`);
  }

  private nameOf(thing: Thing): string | null {
    if ('object' in thing) return this.state.object(thing.object)?.name ?? null;
    const robot = this.state.robot(thing.robot);
    return robot && (robot.name || `#${robot.id}`);
  }

  private poseOf(thing: Thing): Pose | null {
    if ('robot' in thing) return this.state.robotState(thing.robot)?.pose ?? null;
    return this.state.objectPose(thing.object);
  }

  /** Sends a line in a moment. If another one comes before, that counts. */
  private say(line: string): void {
    this.next = line;
    this.timer ??= setTimeout(() => this.flush(), INTERVAL);
  }

  private flush(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
    if (this.next !== null) this.send(this.next);
    this.next = null;
  }
}

function numbers(vector: readonly number[]): string {
  return vector.map((number) => number.toFixed(3)).join(',');
}

function isSame(one: Thing, other: Thing): boolean {
  if ('robot' in one) return 'robot' in other && one.robot === other.robot;
  return 'object' in other && one.object === other.object;
}
