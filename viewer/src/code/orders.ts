/** Orders of a program to the robots of this page. */

import { floorOf, middlesOf, reachToGrip } from '../arm';
import type { Client } from '../protocol/client';
import { type Frame, type RobotState, rollPitchYaw } from '../protocol/frame';
import { readingIn } from '../protocol/line';
import type { RobotClass } from '../protocol/scene';
import type { State } from '../state';

/** Robots of this page, as the tab *Drive* has them. */
export interface Robots {
  /** Client of an own robot that is in the world. */
  clientOf(name: string): Client | null;
  /** Name of the robot that is driven. */
  readonly drivenName: string | null;
  /** Name of an own robot of a class. */
  nameOf(robotClass: string): string | null;
  spawnAnywhere(robotClass: string): void;
}

/** Time until a robot must have come, a sensor measured and joints stand, simulated s. */
const PATIENCE = { robot: 30, sensor: 5, joints: 20 };
/** Joints count as there so near to their targets, and as standing below such a speed: rad and m, for s. */
const THERE = { rad: 0.02, m: 0.001 };
const STILL = { rad: 0.02, m: 0.0005 };
const STANDS = 0.3;
/** Least time between two lines, real ms. */
const LINE_INTERVAL = 20;
/** Orders between two frames, after which a program waits for the next: it would keep the page busy. */
const MOST_ORDERS = 50;
/** The gripper must come so near, m. */
const REACHED = 0.01;

/** Something that a program waits for; called with each frame until it returns something. */
type Condition = (frame: Frame) => object | null;

export class Orders {
  private frame: Frame | null = null;
  private orders = 0;
  /** True once the program has given an order. */
  private hasBegun = false;
  private waiting: { condition: Condition; resolve: (value: object) => void; reject: (error: unknown) => void }[] = [];
  /** Robots that have been driven. */
  private readonly used = new Set<string>();

  constructor(
    private readonly state: State,
    private readonly robots: Robots,
    /** Waits until the server has read what this page has sent. */
    private readonly echo: () => Promise<void>,
  ) {}

  /** Takes the newest frame of the server's world. */
  takeFrame(frame: Frame): void {
    this.frame = frame;
    this.orders = 0;
    this.waiting = this.waiting.filter(({ condition, resolve, reject }) => {
      try {
        const value = condition(frame);
        if (value) resolve(value);
        return !value;
      } catch (error) {
        // The robot has left.
        reject(error);
        return false;
      }
    });
  }

  /** True if a frame is of a world that began anew since the program's first order. */
  isAnew(frame: Frame): boolean {
    return this.hasBegun && frame.time < this.now;
  }

  /** Forgets what is waited for, and stops the robots that were driven. */
  end(): void {
    this.waiting = [];
    this.hasBegun = false;
    for (const name of this.used) {
      const client = this.robots.clientOf(name);
      client?.drive({ forward: 0, right: 0, clockwise: 0, up: 0 });
      client?.heard.clear();
    }
    this.used.clear();
  }

  /** Does an order, and returns what the program gets for it. Fails with a text for people. */
  async do(name: string, values: unknown[]): Promise<unknown> {
    this.hasBegun = true;
    if (++this.orders > MOST_ORDERS) await this.until(() => ({}));
    const [first, ...rest] = values;
    switch (name) {
      case 'take':
        return this.take(first);
      case 'wait':
        return this.wait(number(first, 'seconds'));
      case 'now':
        return this.now;
      case 'drive':
        return this.drive(text(first, 'a robot'), rest);
      case 'see':
        await this.see(text(first, 'a robot'));
        return [this.now, ...this.pose(text(first, 'a robot'))];
      case 'send':
        return this.send(text(first, 'a robot'), text(rest[0], 'a line'));
      case 'read':
        return this.read(text(first, 'a robot'), text(rest[0], 'the name or the type of a sensor'));
      case 'pose':
        return this.pose(text(first, 'a robot'));
      case 'move':
        return this.move(text(first, 'a robot'), rest[0]);
      case 'reach':
        return this.reach(text(first, 'a robot'), rest);
      case 'grip':
        return this.grip(text(first, 'a robot'), rest[0] === true);
      default:
        throw new Error(`there is no order ${name}`);
    }
  }

  private get now(): number {
    return this.frame?.time ?? 0;
  }

  private until<T extends object>(condition: (frame: Frame) => T | null): Promise<T> {
    return new Promise((resolve, reject) => {
      this.waiting.push({ condition, resolve: resolve as (value: object) => void, reject });
    });
  }

  /** Waits until something is so; null after simulated seconds without it. */
  private async within<T extends object>(seconds: number, condition: (frame: Frame) => T | null): Promise<T | null> {
    const end = this.now + seconds;
    const { value } = await this.until((frame) => {
      const value = condition(frame);
      return value || frame.time > end ? { value } : null;
    });
    if (value) return value;
    // A busy page may take frames of seconds at once, and only then what came beside them.
    await this.seeServer();
    return condition(await this.until((frame) => frame));
  }

  /** Waits for a frame that is later than what the server has read from this page. */
  private async seeServer(): Promise<void> {
    await this.echo();
    // The first frame may have waited to be sent.
    let frames = 0;
    await this.until(() => (++frames < 2 ? null : {}));
  }

  /** Waits for a frame that shows what a robot does about its orders. */
  private async see(name: string): Promise<void> {
    while (!this.client(name).isSent) await lineInterval();
    await this.seeServer();
  }

  private async wait(seconds: number): Promise<void> {
    const end = this.now + seconds;
    await this.until(({ time }) => (time >= end ? {} : null));
  }

  private async take(robotClass: unknown): Promise<string> {
    const { robots, state } = this;
    if (robotClass === null) {
      if (robots.drivenName === null) throw new Error('no robot is driven here: take("P3AT") spawns one');
      return robots.drivenName;
    }
    const wanted = text(robotClass, 'a class');
    const known = robots.nameOf(wanted);
    if (known !== null) return known;
    if (!state.scene?.names.includes(wanted)) {
      throw new Error(`there is no class ${wanted}: the form "Spawn a robot" lists all`);
    }
    robots.spawnAnywhere(wanted);
    const came = await this.within(PATIENCE.robot, () => {
      const name = robots.nameOf(wanted);
      return name === null ? null : { name };
    });
    if (!came) throw new Error(`no ${wanted} has come: is a start of the map free?`);
    return came.name;
  }

  private drive(name: string, parts: unknown[]): void {
    const [forward, right, clockwise, up] = ['forward', 'right', 'turn', 'up'].map((part, index) =>
      number(parts[index], part),
    ) as [number, number, number, number];
    this.client(name).drive({ forward, right, clockwise, up });
    this.used.add(name);
  }

  private async send(name: string, line: string): Promise<void> {
    if (/[\r\n]/.test(line)) throw new Error('a line has no line breaks: send one at a time');
    this.client(name).send(line);
    this.used.add(name);
    await lineInterval();
  }

  private async read(name: string, sensor: string): Promise<object> {
    const client = this.client(name);
    this.used.add(name);
    let reading: object | null = null;
    const hear = (line: string) => void (reading ??= readingIn(line, sensor));
    client.heard.add(hear);
    const found = await this.within(PATIENCE.sensor, () => reading);
    client.heard.delete(hear);
    if (found) return found;
    const names = client.robot.sensors.map((sensor) => sensor.name).join(', ');
    throw new Error(`nothing of "${sensor}" came in ${PATIENCE.sensor} s. Sensors of ${name}: ${names || 'none'}`);
  }

  private pose(name: string): number[] {
    const { pose } = this.robot(name);
    return [pose[0], pose[1], pose[2], ...rollPitchYaw(pose)];
  }

  private async move(name: string, targets: unknown): Promise<boolean> {
    const client = this.client(name);
    const wanted = new Map<number, number>();
    for (const [joint, target] of Object.entries(targets ?? {})) {
      const index = client.robot.joints.findIndex((it) => it.name === joint);
      const names = client.robot.joints.map((it) => it.name).join(', ');
      if (index < 0) throw new Error(`${name} has no joint ${joint}. It has ${names || 'none'}`);
      wanted.set(index, number(target, joint));
    }
    wanted.forEach((target, index) => client.setJoint(client.robot.joints[index]!.name, target));
    return this.stand(name, client.robot, wanted);
  }

  private async reach(name: string, place: unknown[]): Promise<boolean> {
    const client = this.client(name);
    const [ahead, right, height] = ['ahead', 'right', 'height'].map((part, index) => number(place[index], part));
    const from = this.robot(name).joints.map(({ position }) => position);
    const floor = floorOf(client.robot);
    const starts = [from, middlesOf(client.robot)];
    const reached = floor === null ? null : reachToGrip(client.robot, starts, [ahead!, right!, floor - height!]);
    if (!reached) throw new Error(`${name} has no arm with a gripper`);
    const { positions, way } = reached;
    if (way > REACHED) {
      const place = [ahead, right, height].join(', ');
      throw new Error(`the gripper comes no nearer than ${(100 * way).toFixed(0)} cm to ${place}`);
    }
    const fingers = new Set(client.robot.grippers.flatMap(({ joints }) => joints));
    const moved = client.robot.joints.flatMap((joint, index) => (fingers.has(joint.name) ? [] : [index]));
    moved.forEach((index) => client.setJoint(client.robot.joints[index]!.name, positions[index]!));
    return this.stand(name, client.robot, new Map(moved.map((index) => [index, positions[index]!])));
  }

  /** Opens or closes the gripper. Returns true if its fingers reach their ends. */
  private async grip(name: string, isOpen: boolean): Promise<boolean> {
    const client = this.client(name);
    const [gripper] = client.robot.grippers;
    if (!gripper) throw new Error(`${name} has no gripper`);
    client.setGripper(gripper.name, isOpen ? 'Open' : 'Close');
    const ends = isOpen ? gripper.open : gripper.closed;
    const fingers = gripper.joints.map((joint) => client.robot.joints.findIndex((it) => it.name === joint));
    return this.stand(name, client.robot, new Map(fingers.map((index, finger) => [index, ends[finger] ?? 0])));
  }

  /** Waits until joints stand. Returns true if all are at their targets. */
  private async stand(name: string, { joints }: RobotClass, targets: Map<number, number>): Promise<boolean> {
    const all = (fits: (index: number, target: number) => boolean) =>
      [...targets].every(([index, target]) => fits(index, target));
    await this.see(name);
    let since = this.now;
    const stood = await this.within(PATIENCE.joints, ({ time }) => {
      const now = this.robot(name).joints;
      const stands = all((index) => Math.abs(now[index]?.speed ?? 0) < STILL[joints[index]!.unit]);
      if (!stands) since = time;
      const isThere = all(
        (index, target) => Math.abs((now[index]?.position ?? 0) - target) < THERE[joints[index]!.unit],
      );
      return time - since > STANDS ? { isThere } : null;
    });
    return stood?.isThere ?? false;
  }

  private client(name: string): Client {
    const client = this.robots.clientOf(name);
    if (!client) throw new Error(`the robot ${name} of this page is not in the world`);
    return client;
  }

  private robot(name: string): RobotState {
    const { id } = this.state.status?.robots.find((robot) => robot.name === name && this.state.isOwn(robot)) ?? {};
    const robot = this.frame?.robots.find((robot) => robot.id === id);
    if (!robot) throw new Error(`the robot ${name} of this page is not in the world`);
    return robot;
  }
}

function lineInterval(): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, LINE_INTERVAL));
}

function text(value: unknown, what: string): string {
  if (typeof value === 'string') return value;
  throw new Error(`expected ${what}, got ${JSON.stringify(value)}`);
}

function number(value: unknown, what: string): number {
  if (typeof value === 'number' && Number.isFinite(value)) return value;
  throw new Error(`${what}: expected a number, got ${JSON.stringify(value)}`);
}
