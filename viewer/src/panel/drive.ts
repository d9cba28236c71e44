/** The tab to spawn a robot and drive it by keyboard or by sticks. */

import { Client, type Spawn, type Twist } from '../protocol/client';
import type { RobotClass } from '../protocol/scene';
import type { State } from '../state';
import { find, make, setText } from './dom';
import { isForControl } from './keys';
import { type Placing, SpawnForm } from './spawn';
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

export class DrivePanel {
  private readonly form: SpawnForm;
  private readonly speed = make('input', { type: 'range', min: '5', max: '100', value: '40', id: 'drive-speed' });
  private readonly speedOutput = make('output', { for: 'drive-speed' });
  private readonly own = make('select', { name: 'own' });
  private readonly hint = make('p', { class: 'quiet', 'data-hint': '' });
  private readonly driving = make('div', { hidden: '' });
  private readonly joints = make('div', { 'data-joints': '' });
  private readonly clients: Client[] = [];
  /** Own robots that are not in the world yet, each with the numbers of those that were there before. */
  private readonly expected = new Map<Client, Set<number>>();
  private readonly pressed = new Set<string>();
  private readonly sticks: { move: Stick; turn: Stick };
  private driven: Client | null = null;

  constructor(
    private readonly state: State,
    place: (placing: Placing) => void,
    private readonly say: (text: string) => void,
    private readonly select: (robot: number) => void,
  ) {
    this.form = new SpawnForm(state, place, say, (spawn) => this.connect(spawn));
    const stop = make('button', { type: 'button', id: 'stop' }, 'Stop');
    stop.onclick = () => this.release();
    const remove = make('button', { type: 'button', id: 'remove' }, 'Remove');
    remove.onclick = () => this.driven && this.remove(this.driven, 'was removed');
    this.own.onchange = () => this.drive(this.clients[this.own.selectedIndex] ?? null);
    this.driving.append(
      make('h2', {}, 'Driving'),
      make('label', { class: 'row' }, 'Robot', this.own),
      make('div', { class: 'row' }, make('label', { for: 'drive-speed' }, 'Speed'), this.speed, this.speedOutput),
      make('div', { class: 'row' }, stop, remove),
      this.hint,
      this.joints,
    );
    find('drive').append(this.driving);
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

  updateScene(): void {
    this.form.updateScene();
    this.updateFrame();
  }

  /** A frame has come: own robots may have arrived, starts may be free or taken. */
  updateFrame(): void {
    const robots = this.state.status?.robots ?? [];
    this.expected.forEach((before, client) => {
      const own = robots.find(({ id, name }) => name === client.spawn.name && !before.has(id));
      if (!own || !this.state.robotState(own.id)) return;
      this.expected.delete(client);
      this.select(own.id);
    });
    this.form.update([...this.expected.keys()].map(({ spawn }) => spawn));
  }

  private connect(spawn: Spawn): void {
    const robotClass = this.state.scene?.classes[spawn.robotClass];
    if (!robotClass) return;
    const client: Client = new Client(spawn, robotClass, (what) => this.remove(client, what));
    this.clients.push(client);
    this.expected.set(client, new Set(this.state.status?.robots.map(({ id }) => id)));
    this.drive(client);
    this.updateFrame();
  }

  private remove(client: Client, what: string): void {
    const index = this.clients.indexOf(client);
    if (index < 0) return;
    this.clients.splice(index, 1);
    this.expected.delete(client);
    client.end();
    this.say(`${client.spawn.name} ${what}`);
    if (this.driven === client) this.drive(this.clients[0] ?? null);
    else this.list();
  }

  private drive(client: Client | null): void {
    this.release();
    this.driven = client;
    this.state.driving = client !== null;
    this.driving.hidden = find('sticks').hidden = client === null;
    const robotClass = client && this.state.scene?.classes[client.spawn.robotClass];
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
      ' turn; or use the sticks in the view.',
    );
    this.joints.replaceChildren(...(robotClass?.joints ?? []).map((joint) => this.slider(joint)));
    this.list();
  }

  /** Moves a joint of the robot that is driven. */
  private slider({ name, min, max }: RobotClass['joints'][number]): HTMLElement {
    const id = `joint-${name}`;
    const range = { min: String(min), max: String(max), step: String((max - min) / 500) };
    const input = make('input', { type: 'range', id, value: String(Math.max(min, Math.min(max, 0))), ...range });
    const output = make('output', { for: id }, Number(input.value).toFixed(3));
    input.oninput = () => {
      setText(output, Number(input.value).toFixed(3));
      this.driven?.setJoint(name, Number(input.value));
    };
    return make('div', { class: 'row' }, make('label', { for: id }, name), input, output);
  }

  private list(): void {
    this.own.replaceChildren(...this.clients.map(({ spawn }) => make('option', {}, spawn.name)));
    this.own.selectedIndex = this.driven ? this.clients.indexOf(this.driven) : -1;
  }

  private key(event: KeyboardEvent, down: boolean): void {
    if (!this.driven || !(event.code in KEYS)) return;
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

  private send(): void {
    const { move, turn } = this.sticks;
    const twist: Twist = { forward: -move.y, right: move.x, clockwise: turn.x, up: 0 };
    this.pressed.forEach((code) => {
      const key = KEYS[code] ?? {};
      twist.forward += key.forward ?? 0;
      twist.right += key.right ?? 0;
      twist.clockwise += key.clockwise ?? 0;
      twist.up += key.up ?? 0;
    });
    const part = Number(this.speed.value) / 100;
    const limited = (value: number) => part * Math.max(-1, Math.min(1, value));
    this.driven?.drive({
      forward: limited(twist.forward),
      right: limited(twist.right),
      clockwise: limited(twist.clockwise),
      up: limited(twist.up),
    });
  }
}

function keys(...names: string[]): HTMLElement[] {
  return names.map((name) => make('kbd', {}, name));
}
