/** The tab to put a robot on the map and drive it by keyboard or by sticks. */

import { Client, type Spawn, type Twist } from '../protocol/client';
import type { Vector } from '../protocol/scene';
import type { State } from '../state';
import { find, make } from './dom';
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
};

/** What a click on the map is for. */
export type Placing = ((place: Vector) => void) | null;

export class DrivePanel {
  private readonly classes = make('select', { name: 'class' });
  private readonly starts = make('select', { name: 'start' });
  private readonly name = make('input', { name: 'name', value: 'Robot1', maxlength: '40', autocomplete: 'off' });
  private readonly speed = make('input', { type: 'range', min: '5', max: '100', value: '40', name: 'speed' });
  private readonly own = make('select', { name: 'own' });
  private readonly hint = make('p', { class: 'quiet', 'data-hint': '' });
  private readonly driving = make('div', { hidden: '' });
  private readonly clients: Client[] = [];
  private readonly pressed = new Set<string>();
  private readonly sticks: { move: Stick; turn: Stick };
  private driven: Client | null = null;

  constructor(
    private readonly state: State,
    private readonly place: (placing: Placing) => void,
    private readonly say: (text: string) => void,
    private readonly select: (name: string) => void,
  ) {
    const spawn = make('button', { type: 'submit', id: 'spawn' }, 'Spawn');
    const form = make(
      'form',
      {},
      make('h2', {}, 'Spawn a robot'),
      make('label', {}, 'Class', this.classes),
      make('label', {}, 'Start', this.starts),
      make('label', {}, 'Name', this.name),
      make('div', { class: 'row' }, spawn),
    );
    form.onsubmit = (event) => {
      event.preventDefault();
      this.spawn();
    };
    const stop = make('button', { type: 'button', id: 'stop' }, 'Stop');
    stop.onclick = () => this.release();
    const leave = make('button', { type: 'button', id: 'leave' }, 'Remove');
    leave.onclick = () => this.driven && this.remove(this.driven, 'it was removed');
    this.own.onchange = () => this.drive(this.clients[this.own.selectedIndex] ?? null);
    this.driving.append(
      make('h2', {}, 'Driving'),
      make('label', {}, 'Robot ', this.own),
      make('label', { class: 'row' }, 'Speed ', this.speed),
      make('div', { class: 'row' }, stop, leave),
      this.hint,
    );
    find('drive').append(form, this.driving);
    this.sticks = { move: new Stick(false, () => this.tell()), turn: new Stick(true, () => this.tell()) };
    find('sticks').append(this.sticks.move.element, this.sticks.turn.element);
    this.speed.oninput = () => this.tell();
    window.addEventListener('keydown', (event) => this.key(event, true));
    window.addEventListener('keyup', (event) => this.key(event, false));
    // Nobody holds a key of a page that is not in front.
    window.addEventListener('blur', () => this.release());
    document.addEventListener('visibilitychange', () => document.hidden && this.release());
  }

  /** Another world: its classes and its places. */
  updateScene(): void {
    const { scene } = this.state;
    if (!scene) return;
    const keep = this.classes.value || 'KUKA_YouBot';
    this.classes.replaceChildren(...Object.keys(scene.classes).map((name) => make('option', { value: name }, name)));
    if (scene.classes[keep]) this.classes.value = keep;
    this.starts.replaceChildren(
      ...scene.map.starts.map(({ name }) => make('option', { value: name }, name)),
      make('option', { value: '' }, 'where I click on the map'),
    );
  }

  private spawn(): void {
    const robotClass = this.state.scene?.classes[this.classes.value];
    if (!robotClass) return;
    const start = this.starts.value;
    if (start) this.connect({ start });
    else {
      this.say('Click on the map where the robot is to stand');
      this.place((location) => this.connect({ location: [location[0], location[1], location[2] - 0.01], yaw: 0 }));
    }
  }

  private connect(place: Spawn['place']): void {
    const robotClass = this.state.scene?.classes[this.classes.value];
    if (!robotClass) return;
    // A name on the wire has no white space and no braces.
    const name = this.name.value.replace(/[\s{}]+/g, '_') || 'Robot1';
    const spawn = { robotClass: this.classes.value, name, place };
    const client: Client = new Client(
      spawn,
      robotClass,
      (reason) => this.remove(client, reason),
      () => this.select(name),
    );
    this.clients.push(client);
    this.drive(client);
    const [, stem = '', number = '1'] = /^(.*?)(\d*)$/.exec(name) ?? [];
    this.name.value = `${stem}${Number(number) + 1}`;
  }

  private remove(client: Client, reason: string): void {
    const index = this.clients.indexOf(client);
    if (index < 0) return;
    this.clients.splice(index, 1);
    client.end();
    this.say(`${client.spawn.name} has left: ${reason}`);
    if (this.driven === client) this.drive(this.clients[0] ?? null);
    else this.list();
  }

  private drive(client: Client | null): void {
    this.release();
    this.driven = client;
    this.driving.hidden = find('sticks').hidden = client === null;
    const robotClass = client && this.state.scene?.classes[client.spawn.robotClass];
    const sideways = robotClass?.steering === 'OmniDrive';
    this.sticks.move.sideways = sideways;
    this.hint.replaceChildren(
      ...keys('W', 'S'),
      ' forward and back, ',
      ...(sideways ? [...keys('A', 'D'), ' sideways, '] : []),
      ...keys('Q', 'E'),
      ' or ',
      ...keys('←', '→'),
      ' turn; or use the sticks in the view.',
    );
    this.list();
  }

  private list(): void {
    this.own.replaceChildren(...this.clients.map(({ spawn }) => make('option', {}, spawn.name)));
    this.own.selectedIndex = this.driven ? this.clients.indexOf(this.driven) : -1;
  }

  private key(event: KeyboardEvent, down: boolean): void {
    if (!this.driven || !(event.code in KEYS) || event.ctrlKey || event.metaKey || event.altKey) return;
    const typing = event.target instanceof HTMLElement && event.target.matches('input:not([type=range]), select');
    if (down && typing) return;
    event.preventDefault();
    if (down) this.pressed.add(event.code);
    else this.pressed.delete(event.code);
    this.tell();
  }

  private release(): void {
    this.pressed.clear();
    this.sticks.move.release();
    this.sticks.turn.release();
    this.tell();
  }

  private tell(): void {
    const { move, turn } = this.sticks;
    const twist: Twist = { forward: -move.y, right: move.x, clockwise: turn.x };
    this.pressed.forEach((code) => {
      const key = KEYS[code] ?? {};
      twist.forward += key.forward ?? 0;
      twist.right += key.right ?? 0;
      twist.clockwise += key.clockwise ?? 0;
    });
    const part = Number(this.speed.value) / 100;
    const limited = (value: number) => part * Math.max(-1, Math.min(1, value));
    this.driven?.drive({
      forward: limited(twist.forward),
      right: limited(twist.right),
      clockwise: limited(twist.clockwise),
    });
  }
}

function keys(...names: string[]): HTMLElement[] {
  return names.map((name) => make('kbd', {}, name));
}
