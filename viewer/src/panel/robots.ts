/** The tab of robots and clients. */

import { rollPitchYaw } from '../protocol/frame';
import type { State } from '../state';
import { colourOf } from '../view/overlay';
import { find, make, setText } from './dom';

const RADIANS = 180 / Math.PI;

export class RobotsPanel {
  private readonly list = make('ul', { class: 'robots-list' });
  private readonly details = make('div');
  private readonly clients = make('div');
  private shown = '';
  private cells = new Map<string, HTMLElement>();

  constructor(
    private readonly state: State,
    private readonly select: (robot: number) => void,
  ) {
    find('robots').append(make('h2', {}, 'Robots'), this.list, this.details, make('h2', {}, 'Clients'), this.clients);
  }

  /** A status has come, or another robot is selected. */
  updateStatus(): void {
    const { status, selected } = this.state;
    if (!status) return;
    const shown = JSON.stringify([status.robots, status.clients, selected]);
    if (shown === this.shown) return;
    this.shown = shown;
    this.list.replaceChildren(
      ...status.robots.map((robot) => {
        const battery = robot.battery === null ? '' : ` · battery ${robot.battery} s`;
        const text = make('span', {}, robot.name || robot.class);
        const small = make('small', {}, ` #${robot.id} ${robot.class}${battery}`);
        const pressed = String(robot.id === selected);
        const button = make('button', { 'data-robot': String(robot.id), 'aria-pressed': pressed }, text, small);
        button.style.setProperty('--robot', colourOf(robot.id));
        button.onclick = () => this.select(robot.id);
        return make('li', {}, button);
      }),
    );
    if (status.robots.length === 0) {
      const port = this.state.scene?.port ?? 3000;
      this.list.append(
        make('li', {}, `No robot yet. Spawn one in the tab Drive, or connect a controller to port ${port}.`),
      );
    }
    this.clients.replaceChildren(
      ...(status.clients.length === 0
        ? [make('p', { class: 'quiet' }, 'None')]
        : [
            table(
              ['no.', 'address', 'robots', 'lines', 'dropped'],
              status.clients.map(({ connection, peer, lines, dropped }) => {
                const robots = status.robots.filter((robot) => robot.connection === connection);
                const names = robots.map(({ name, id }) => name || `#${id}`).join(', ');
                return [String(connection), peer, names, String(lines), String(dropped)];
              }),
            ),
          ]),
    );
    this.buildDetails();
    this.updateFrame();
  }

  /** A frame has come. */
  updateFrame(): void {
    const robot = this.state.robotState(this.state.selected);
    if (!robot) return;
    const [roll, pitch, yaw] = rollPitchYaw(robot.pose);
    const [x, y, z] = robot.pose;
    const weight = robot.contacts.reduce((sum, { force }) => sum - force[2], 0);
    const values: Record<string, string> = {
      x: x.toFixed(3),
      y: y.toFixed(3),
      z: z.toFixed(3),
      roll: (roll * RADIANS).toFixed(1),
      pitch: (pitch * RADIANS).toFixed(1),
      yaw: (yaw * RADIANS).toFixed(1),
      forward: robot.linear[0].toFixed(3),
      right: robot.linear[1].toFixed(3),
      clockwise: robot.angular[2].toFixed(3),
      contacts: `${robot.contacts.length}, ${weight.toFixed(1)} N up`,
    };
    robot.wheels.forEach(({ target, speed, angle }, index) => {
      values[`target${index}`] = target.toFixed(2);
      values[`speed${index}`] = speed.toFixed(2);
      values[`angle${index}`] = angle.toFixed(2);
    });
    Object.entries(values).forEach(([name, text]) => {
      const cell = this.cells.get(name);
      if (cell) setText(cell, text);
    });
  }

  private buildDetails(): void {
    this.cells = new Map();
    const robot = this.state.robot(this.state.selected);
    const robotClass = this.state.classOf(this.state.selected);
    if (!robot || !robotClass) {
      this.details.replaceChildren();
      return;
    }
    const value = (name: string) => {
      const cell = make('td', { class: 'number', 'data-value': name });
      this.cells.set(name, cell);
      return cell;
    };
    const row = (...names: [string, string][]) =>
      make('tr', {}, ...names.flatMap(([name, unit]) => [make('th', {}, `${name} ${unit}`), value(name)]));
    const pose = make(
      'table',
      {},
      row(['x', 'm'], ['roll', '°']),
      row(['y', 'm'], ['pitch', '°']),
      row(['z', 'm'], ['yaw', '°']),
      row(['forward', 'm/s'], ['right', 'm/s']),
      row(['clockwise', 'rad/s'], ['contacts', '']),
    );
    const heads = ['wheel', 'target rad/s', 'measured rad/s', 'angle rad'];
    const wheels = make(
      'table',
      {},
      make('tr', {}, ...heads.map((head, index) => make('th', index > 0 ? { class: 'number' } : {}, head))),
      ...robotClass.wheels.map(({ name }, index) =>
        make('tr', {}, make('td', {}, name), value(`target${index}`), value(`speed${index}`), value(`angle${index}`)),
      ),
    );
    this.details.replaceChildren(
      make('h2', {}, `${robot.name || robot.class}`),
      make('p', { class: 'quiet' }, `${robotClass.description} (${robotClass.drive_model})`),
      pose,
      make('h2', {}, 'Wheels'),
      wheels,
    );
  }
}

function table(heads: string[], rows: string[][]): HTMLElement {
  return make(
    'table',
    {},
    make('tr', {}, ...heads.map((head) => make('th', {}, head))),
    ...rows.map((row) => make('tr', {}, ...row.map((cell) => make('td', {}, cell)))),
  );
}
