/** The tab to spawn a robot and drive it by keyboard or by sticks. */

import { Client, type Spawn, type Twist, initLine } from '../protocol/client';
import type { RobotClass, Vector } from '../protocol/scene';
import type { Transport } from '../protocol/transport';
import type { State } from '../state';
import { find, make, setText } from './dom';
import { readGamepad } from './gamepad';
import { JointsPanel } from './joints';
import { isForControl } from './keys';
import { type Placing, SpawnForm, spawnPlace } from './spawn';
import { Stick } from './stick';

const KEYS: Record<string, Partial<Twist>> = {
  KeyW: { forward: 1 },
  ArrowUp: { forward: 1 },
  KeyS: { forward: -1 },
  ArrowDown: { forward: -1 },
  KeyA: { right: -1 },
  KeyD: { right: 1 },
  KeyQ: { clockwise: -1 },
  ArrowLeft: { clockwise: -1 },
  KeyE: { clockwise: 1 },
  ArrowRight: { clockwise: 1 },
  KeyR: { up: 1 },
  KeyF: { up: -1 },
};

/** Names of the keys for people. */
export const DRIVING_KEYS = [
  { keys: ['W', 'S', '↑', '↓'], what: 'forward and back' },
  { keys: ['A', 'D'], what: 'sideways' },
  { keys: ['Q', 'E', '←', '→'], what: 'turn' },
  { keys: ['R', 'F'], what: 'up and down' },
];

/** Choice of all own robots at once. */
const TOGETHER = 'all together';

/** A robot that was spawned by this page. */
interface Own {
  client: Client;
  /** Number of its connection, once it is in the world. */
  connection: number | null;
  /** Numbers of the robots that were there before it. */
  before: Set<number>;
  /** Robot that was driven before it. */
  previous: Own | null;
}

export class DrivePanel {
  private readonly form: SpawnForm;
  private readonly speed = make('input', { type: 'range', min: '5', max: '100', value: '40', id: 'drive-speed' });
  private readonly speedOutput = make('output', { for: 'drive-speed' });
  private readonly own = make('select', { name: 'own' });
  private readonly hint = make('p', { class: 'quiet', 'data-hint': '' });
  private readonly driving = make('div', { hidden: '' });
  private readonly joints = new JointsPanel();
  private readonly robots: Own[] = [];
  private readonly pressed = new Set<string>();
  private readonly sticks: { move: Stick; turn: Stick };
  private driven: Own | null = null;
  /** True if keys and sticks drive all own robots. */
  private isTogether = false;
  private padWasUsed = false;
  /** True if the last command was not to stand. */
  private wasTouched = false;

  constructor(
    private readonly state: State,
    place: (placing: Placing) => void,
    private readonly say: (text: string) => void,
    private readonly select: (robot: number, isNew: boolean) => void,
    private readonly spawned: () => void,
    private readonly classOf: (name: string) => Promise<RobotClass | null>,
    private readonly transport: Transport,
  ) {
    this.form = new SpawnForm(
      state,
      place,
      (spawn) => this.spawn(spawn),
      (robotClass) => void classOf(robotClass),
    );
    const stop = make('button', { type: 'button', id: 'stop' }, 'Stop');
    stop.onclick = () => this.release();
    const remove = make('button', { type: 'button', id: 'remove' }, 'Remove');
    remove.onclick = () => this.driven && this.remove(this.driven, 'was removed');
    this.own.onchange = () => {
      const { selectedIndex } = this.own;
      this.drive(this.robots[selectedIndex] ?? this.robots[0] ?? null, selectedIndex === this.robots.length);
      const driven = this.state.status?.robots.find(({ connection }) => connection === this.driven?.connection);
      if (driven) this.select(driven.id, false);
    };
    this.driving.append(
      make('h2', {}, 'Driving'),
      make('label', { class: 'row' }, 'Robot', this.own),
      make('div', { class: 'row' }, make('label', { for: 'drive-speed' }, 'Speed'), this.speed, this.speedOutput),
      make('div', { class: 'row' }, stop, remove),
      this.hint,
      this.joints.element,
    );
    find('drive').prepend(this.driving);
    this.sticks = { move: new Stick(false, () => this.send()), turn: new Stick(true, () => this.send()) };
    find('sticks').append(this.sticks.move.element, this.sticks.turn.element);
    const showSpeed = () => setText(this.speedOutput, `${this.speed.value} %`);
    showSpeed();
    this.speed.oninput = () => {
      showSpeed();
      this.send();
    };
    window.addEventListener('keydown', (event) => this.key(event, true));
    window.addEventListener('keyup', (event) => this.key(event, false));
    // Nobody holds a key of a page that is not in front.
    window.addEventListener('blur', () => this.release());
    document.addEventListener('visibilitychange', () => document.hidden && this.release());
  }

  /** Class of the driven robot; null without one. */
  get robotClass(): RobotClass | null {
    return this.driven?.client.robot ?? null;
  }

  /** Sends a line that somebody typed as the driven robot's client. Returns false without one. */
  sendLine(line: string): boolean {
    this.driven?.client.send(line);
    return this.driven !== null;
  }

  /** Client of an own robot that is in the world. */
  clientOf(name: string): Client | null {
    return this.inWorld.find((client) => client.spawn.name === name) ?? null;
  }

  /** Name of the robot that is driven; null without one. */
  get drivenName(): string | null {
    return this.driven?.client.spawn.name ?? null;
  }

  /** Name of an own robot of a class, the driven one before others; null without one in the world. */
  nameOf(robotClass: string): string | null {
    const fitting = this.inWorld.filter(({ spawn }) => spawn.robotClass === robotClass);
    return (fitting.find(({ spawn }) => spawn.name === this.drivenName) ?? fitting[0])?.spawn.name ?? null;
  }

  private get inWorld(): Client[] {
    return this.robots.filter(({ connection }) => connection !== null).map(({ client }) => client);
  }

  /** Moves joints of the driven robot to positions, by their names. */
  moveJoints(positions: ReadonlyMap<string, number>): void {
    this.joints.moveJoints(positions);
  }

  updateScene(): void {
    this.form.updateScene();
    this.follow();
    this.followJoints();
  }

  /** Releases the keys when another moment is shown. Nobody drives in the past or in a log. */
  updateMode(): void {
    this.release();
    find('sticks').hidden = !this.state.driving;
    this.followJoints();
  }

  /** Follows the world: own robots may have arrived, starts may be free or taken, and a gamepad may be touched; to be called ten times a second. */
  follow(): void {
    const robots = this.state.status?.robots ?? [];
    const expected = this.robots.filter(({ connection }) => connection === null);
    for (const own of expected) {
      const arrived = robots.find(({ id, name }) => name === own.client.spawn.name && !own.before.has(id));
      if (!arrived || arrived.connection === null || !this.state.robotState(arrived.id)) continue;
      own.connection = arrived.connection;
      this.state.own.add(arrived.connection);
      const wasTogether = this.isTogether;
      this.select(arrived.id, true);
      // It was chosen while the robot was on its way.
      if (wasTogether) this.drive(this.driven, true);
    }
    const waiting = this.robots.filter(({ connection }) => connection === null);
    this.form.update(waiting.map(({ client }) => client.spawn));
    this.readPad();
  }

  /** Opens the form. */
  focusForm(): void {
    this.form.focus();
  }

  /** Takes all own robots away. */
  leaveAll(): void {
    [...this.robots].forEach((own) => this.forget(own));
  }

  /** Spawns a robot of a class at the first start that is free. */
  spawnAnywhere(robotClass: string): void {
    this.form.choose(robotClass);
  }

  /** Spawns a robot of a class at a place. In a league it enters at a start of its team. */
  spawnAt(robotClass: string, location: Vector): void {
    this.form.choose(robotClass, this.state.scene?.league ? null : location);
  }

  /** Drives a robot if it was spawned here. */
  driveIfOwn(robot: number): void {
    const connection = this.state.robot(robot)?.connection;
    const own = this.robots.find((own) => own.connection !== null && own.connection === connection);
    if (own && own !== this.driven) this.drive(own);
  }

  /** Spawns a robot of the form's class at a place of the floor. */
  spawnHere(place: Vector): void {
    this.spawnAt(this.form.robotClass, spawnPlace(place));
  }

  /** Spawns a robot as it is said, whatever the form offers. */
  spawn(spawn: Spawn): void {
    const { robotClass: name } = spawn;
    const known = this.state.scene?.classes[name];
    // Keys that are pressed from now on drive the robot, so a class that is there is not waited for.
    if (known) return this.enter(spawn, known);
    void this.classOf(name).then((robotClass) => {
      if (robotClass) this.enter(spawn, robotClass);
      else this.say(`The server does not send the class ${name}: try again`);
    });
  }

  private enter(spawn: Spawn, robotClass: RobotClass): void {
    const before = new Set(this.state.status?.robots.map(({ id }) => id));
    const client: Client = new Client(spawn, robotClass, (what) => this.remove(own, what), this.transport);
    const own: Own = { client, connection: null, before, previous: this.driven };
    this.state.ownInits.add(initLine(spawn));
    this.robots.push(own);
    this.drive(own);
    this.spawned();
    this.follow();
    this.followJoints();
  }

  private remove(own: Own, what: string): void {
    const { name } = own.client.spawn;
    if (!this.forget(own)) return;
    this.say(`${name} ${what}`);
    if (own.connection === null) this.form.offerName(name);
  }

  /** Ends an own robot's connection; false if that was done before. */
  private forget(own: Own): boolean {
    const index = this.robots.indexOf(own);
    if (index < 0) return false;
    this.robots.splice(index, 1);
    if (own.connection !== null) this.state.own.delete(own.connection);
    own.client.end();
    const previous = this.robots.find((other) => other === own.previous) ?? this.robots[0] ?? null;
    if (this.driven === own) this.drive(previous);
    else this.list();
    return true;
  }

  private drive(own: Own | null, isTogether = false): void {
    this.release();
    this.driven = own;
    this.isTogether = isTogether;
    this.state.hasRobot = own !== null;
    this.driving.hidden = own === null;
    find('sticks').hidden = !this.state.driving;
    const robotClass = own?.client.robot;
    const flies = robotClass?.steering === 'Aerial';
    const sideways = flies || robotClass?.steering === 'OmniDrive';
    this.sticks.move.sideways = sideways;
    this.hint.replaceChildren(
      ...keys('W', 'S'),
      ' forward and back, ',
      ...(sideways ? [...keys('A', 'D'), ' sideways, '] : []),
      ...(flies ? [...keys('R', 'F'), ' up and down, '] : []),
      ...keys('Q', 'E'),
      ' or ',
      ...keys('←', '→'),
      ' turn; or use a gamepad, or the sticks in the view on a touch screen.',
    );
    this.joints.build(own?.client.spawn.robotClass ?? '', robotClass ?? null, () => this.driven?.client);
    this.followJoints();
    this.list();
  }

  /** Shows the joints as they are now. */
  followJoints(): void {
    const { connection = null } = this.driven ?? {};
    const driven = this.state.status?.robots.find((robot) => connection !== null && robot.connection === connection);
    this.joints.update(this.state.robotState(driven?.id ?? null), this.state.isPresent);
  }

  private list(): void {
    const names = this.robots.map(({ client }) => client.spawn.name);
    this.isTogether &&= names.length > 1;
    this.own.replaceChildren(
      ...[...names, ...(names.length > 1 ? [TOGETHER] : [])].map((it) => make('option', {}, it)),
    );
    const index = this.driven ? this.robots.indexOf(this.driven) : -1;
    this.own.selectedIndex = this.isTogether ? names.length : index;
  }

  private key(event: KeyboardEvent, down: boolean): void {
    if (!this.driven || !this.state.isPresent || !(event.code in KEYS)) return;
    if (down) {
      if (event.ctrlKey || event.metaKey || event.altKey || isForControl(event, true)) return;
      this.pressed.add(event.code);
    } else if (!this.pressed.delete(event.code)) return;
    event.preventDefault();
    this.send();
  }

  private release(): void {
    this.pressed.clear();
    this.sticks.move.release();
    this.sticks.turn.release();
    this.send();
  }

  /** A gamepad is only listened to while it is touched, so that it does not hold up keys and sticks. */
  private readPad(): void {
    if (!this.driven || !this.state.isPresent) return;
    const pad = readGamepad();
    const isUsed = pad !== null && Object.values(pad).some((part) => part !== 0);
    if (isUsed || this.padWasUsed) this.send(pad);
    this.padWasUsed = isUsed;
  }

  private send(pad: Twist | null = this.state.isPresent ? readGamepad() : null): void {
    const { move, turn } = this.sticks;
    const twist: Twist = pad ?? { forward: 0, right: 0, clockwise: 0, up: 0 };
    twist.forward -= move.y;
    twist.right += move.x;
    twist.clockwise += turn.x;
    this.pressed.forEach((code) => {
      const key = KEYS[code] ?? {};
      twist.forward += key.forward ?? 0;
      twist.right += key.right ?? 0;
      twist.clockwise += key.clockwise ?? 0;
      twist.up += key.up ?? 0;
    });
    const isTouched = Object.values(twist).some((part) => part !== 0);
    // A program drives while nobody does.
    const isLeft = !isTouched && !this.wasTouched;
    this.wasTouched = isTouched;
    if (this.state.isProgrammed && isLeft) return;
    const part = Number(this.speed.value) / 100;
    const limited = (value: number) => part * Math.max(-1, Math.min(1, value));
    const driven = this.isTogether ? this.robots : [this.driven];
    driven.forEach((own) =>
      own?.client.drive({
        forward: limited(twist.forward),
        right: limited(twist.right),
        clockwise: limited(twist.clockwise),
        up: limited(twist.up),
      }),
    );
  }
}

function keys(...names: string[]): HTMLElement[] {
  return names.map((name) => make('kbd', {}, name));
}
