/** The tree of what is in the world, with the values of robots; a click on a value plots it. */

import type { State } from '../state';
import { type Group, POSE, type PoseValue, type Shown, type Value, valuesOf } from '../values';
import type { Vector } from '../protocol/scene';
import { find, fixed, make, remember, remembered, setText } from './dom';
import type { Pictures } from './pictures';

/** Student2 is before Student10. */
const BY_NAME = new Intl.Collator('en', { numeric: true });

/** Actions of clicks in the tree. */
export interface WorldActions {
  select: (robot: number) => void;
  chooseObject: (number: number) => void;
  chooseMap: () => void;
  lookAt: (place: Vector) => void;
  isPlotted: (robot: number, key: string) => boolean;
  plot: (robot: number, value: Value) => void;
  isPlottedOfObject: (object: number, key: string) => boolean;
  plotOfObject: (object: number, value: PoseValue) => void;
  /** Other robots show their values than before. */
  expanded: (robots: number[]) => void;
}

/** A value in the tree, with the number that it has now and whether it is plotted. */
interface Cell {
  value: Shown;
  now: () => number | null;
  isPlotted: () => boolean;
  output: HTMLElement;
  button: HTMLElement;
}

export class WorldPanel {
  private readonly robots = make('ul', { class: 'tree', id: 'robots', 'aria-label': 'Robots' });
  private readonly rest = make('div', {});
  /** Robots whose values a person has opened or closed. */
  private readonly opened = new Map<number, boolean>();
  /** Groups that a person has opened or closed, by their names. */
  private readonly openGroups = new Map<string, boolean>([
    ['Pose', true],
    ['Velocity', true],
  ]);
  private cells: Cell[] = [];
  private shown = '';

  constructor(
    private readonly state: State,
    private readonly pictures: Pictures,
    private readonly actions: WorldActions,
    spawn: () => void,
  ) {
    const button = make(
      'button',
      { id: 'open-spawn', class: 'main wide', title: 'Spawn a robot (N)' },
      '+ Spawn a robot',
    );
    button.onclick = spawn;
    const scroll = make('div', { class: 'scroll' }, heading('Robots'), this.robots, this.rest);
    find('world').append(scroll, make('div', { class: 'foot' }, button));
  }

  /** Robots, objects, clients or the selection are others. */
  update(): void {
    const shown = this.signature();
    if (shown === this.shown) return;
    this.shown = shown;
    this.build();
    this.updateValues();
  }

  /** Writes the values as they are now; to be called a few times a second. */
  updateValues(): void {
    // A sensor that speaks for the first time has new rows.
    if (this.signature() !== this.shown) return this.update();
    for (const { value, now, isPlotted, output, button } of this.cells) {
      const number = now();
      setText(output, number === null ? '–' : fixed(number, value.digits));
      button.setAttribute('aria-pressed', String(isPlotted()));
    }
    this.pictures.update();
  }

  private isOpen(robot: number): boolean {
    return this.opened.get(robot) ?? robot === this.state.selected;
  }

  private groups(robot: number): Group[] {
    const robotClass = this.state.classOf(robot);
    return robotClass ? valuesOf(robotClass, this.state.sensorsOf(robot)) : [];
  }

  /** Returns the data that decide the tree's shape, as a text. */
  private signature(): string {
    const { status, scene, selected } = this.state;
    const robots = (status?.robots ?? []).map((robot) => {
      const count = this.isOpen(robot.id)
        ? this.groups(robot.id).reduce((sum, { values }) => sum + values.length, 0)
        : -1;
      const cameras = this.state.classOf(robot.id)?.sensors.map(({ name, camera }) => camera && [name, camera]);
      return [robot.id, robot.class, robot.name, robot.connection, this.state.isOwn(robot), count, cameras];
    });
    const clients = (status?.clients ?? []).map(({ connection, dropped }) => [connection, dropped]);
    const objects = this.state.objects.map((number) => [number, this.state.object(number)?.name]);
    return JSON.stringify([
      scene?.map.name,
      scene?.scenario?.name,
      selected,
      this.state.chosenObject,
      this.state.isMapChosen,
      robots,
      objects,
      clients,
      status?.viewers,
    ]);
  }

  private build(): void {
    const { status, scene } = this.state;
    const robots = status?.robots ?? [];
    const [robotInFocus, objectInFocus, cameraInFocus] = ['data-robot', 'data-object', 'data-camera'].map((name) =>
      document.activeElement?.getAttribute(name),
    );
    this.cells = [];
    const sorted = robots.map(({ id }) => ({ id, name: this.state.nameOf(id) }));
    sorted.sort((one, other) => BY_NAME.compare(one.name, other.name) || one.id - other.id);
    this.robots.replaceChildren(...sorted.map(({ id }) => this.robot(id)));
    if (robots.length === 0) {
      const how = this.state.isWatched ? '' : ` Spawn one, or connect a controller to port ${scene?.port ?? 3000}.`;
      this.robots.append(make('li', { class: 'quiet' }, `No robot yet.${how}`));
    }
    if (robotInFocus) this.robots.querySelector<HTMLElement>(`[data-robot="${robotInFocus}"]`)?.focus();
    if (cameraInFocus) this.robots.querySelector<HTMLElement>(`[data-camera="${cameraInFocus}"]`)?.focus();
    this.actions.expanded(robots.map(({ id }) => id).filter((id) => this.isOpen(id)));
    const objects = this.state.objects.map((number) => {
      const name = this.state.object(number)?.name ?? '';
      const isChosen = number === this.state.chosenObject;
      const pressed = String(isChosen);
      const button = make('button', { class: 'leaf', 'data-object': String(number), 'aria-pressed': pressed }, name);
      button.onclick = () => this.actions.chooseObject(number);
      return make('li', {}, button, ...(isChosen ? [this.objectGroup(number)] : []));
    });
    const clients = (status?.clients ?? []).map(({ connection, peer, dropped }) => {
      const names = robots.filter((robot) => robot.connection === connection).map(({ id }) => this.state.nameOf(id));
      const lost = dropped > 0 ? `, too slow for ${dropped} ${dropped === 1 ? 'line' : 'lines'}` : '';
      return make('li', {}, `${connection}: ${names.join(', ') || 'no robot'} `, make('small', {}, peer + lost));
    });
    const viewers = status?.viewers ?? 0;
    const pages = viewers === 1 ? 'Only this page is open.' : `${viewers} pages are open, including this one.`;
    const none = make('li', { class: 'quiet' }, 'None');
    const isMapChosen = String(this.state.isMapChosen);
    const map = make('button', { class: 'leaf', id: 'map-row', 'aria-pressed': isMapChosen }, scene?.map.name ?? '');
    map.onclick = () => this.actions.chooseMap();
    const wasMap = document.activeElement?.id === 'map-row';
    this.rest.replaceChildren(
      ...section('Map', [make('li', {}, map)], true, 0),
      ...section('Objects', objects, true),
      ...this.sights(),
      ...section('Clients', clients.length > 0 ? clients : [none], true, clients.length),
      ...(viewers > 0 ? [make('p', { class: 'quiet' }, pages)] : []),
    );
    if (wasMap) map.focus();
    if (objectInFocus) this.rest.querySelector<HTMLElement>(`[data-object="${objectInFocus}"]`)?.focus();
  }

  /** Returns what the map has beside solids and objects, and the places of goals; a click looks there. */
  private sights(): HTMLElement[] {
    const { map, league } = this.state.scene ?? {};
    const goals = (league?.targets ?? []).map(({ name, position, size, radius }) => {
      const about = size ? `${size.join(' x ')} m` : `within ${radius} m`;
      return { kind: 'Goals', name, position, about };
    });
    const all = [...(map?.sights ?? []), ...goals];
    return [...new Set(all.map(({ kind }) => kind))].flatMap((kind) => {
      const items = all
        .filter((sight) => sight.kind === kind)
        .map(({ name, position, about }) => {
          const button = make('button', { class: 'leaf', 'data-sight': name }, name, make('small', {}, about));
          button.onclick = () => this.actions.lookAt(position);
          return make('li', {}, button);
        });
      return section(kind, items, false);
    });
  }

  private robot(id: number): HTMLElement {
    const robot = this.state.robot(id);
    const name = this.state.nameOf(id);
    const open = this.isOpen(id);
    const expander = make(
      'button',
      { class: 'expander', 'aria-expanded': String(open), 'aria-label': `Values of ${name}` },
      open ? '▾' : '▸',
    );
    expander.onclick = () => {
      this.opened.set(id, !open);
      this.update();
    };
    const swatch = make('i', { class: 'swatch' });
    swatch.style.background = this.state.colourOf(id);
    const own = robot && this.state.isOwn(robot) ? ' · yours' : '';
    const pressed = String(id === this.state.selected);
    const button = make(
      'button',
      { class: 'leaf', 'data-robot': String(id), 'aria-pressed': pressed },
      swatch,
      make('span', {}, name),
      make('small', {}, `${robot?.class ?? ''}${own}`),
    );
    button.onclick = () => this.actions.select(id);
    const item = make('li', {}, make('div', { class: 'branch' }, expander, button));
    if (open) item.append(...this.pictures.of(id), ...this.groups(id).map((group) => this.group(id, group)));
    return item;
  }

  /** Returns the chosen object's pose, whose numbers can be plotted. */
  private objectGroup(object: number): HTMLElement {
    const rows = POSE.map((value) => {
      const now = () => {
        const pose = this.state.objectPose(object);
        return pose && value.read({ pose });
      };
      const isPlotted = () => this.actions.isPlottedOfObject(object, value.key);
      return this.cell(value, 'data-object-value', now, isPlotted, () => this.actions.plotOfObject(object, value));
    });
    return make('div', { class: 'group' }, ...rows);
  }

  private group(robot: number, { name, values }: Group): HTMLElement {
    const details = make('details', { class: 'group' }, make('summary', {}, name));
    details.open = this.openGroups.get(name) ?? false;
    details.ontoggle = () => this.openGroups.set(name, details.open);
    for (const value of values) {
      const now = () => {
        const robotState = this.state.robotState(robot);
        return robotState && value.read(robotState, this.state.sensorsOf(robot));
      };
      const isPlotted = () => this.actions.isPlotted(robot, value.key);
      details.append(this.cell(value, 'data-value', now, isPlotted, () => this.actions.plot(robot, value)));
    }
    return details;
  }

  /** Returns the row of a value; a click plots it. */
  private cell(
    value: Shown,
    attribute: string,
    now: Cell['now'],
    isPlotted: Cell['isPlotted'],
    plot: () => void,
  ): HTMLElement {
    const output = make('output', { [attribute]: value.key });
    const button = make(
      'button',
      { class: 'value', 'aria-pressed': 'false', title: `Plot ${value.name}` },
      make('span', {}, value.name),
      output,
      make('small', {}, value.unit),
    );
    button.onclick = () => {
      plot();
      this.updateValues();
    };
    this.cells.push({ value, now, isPlotted, output, button });
    return button;
  }
}

function heading(text: string): HTMLElement {
  return make('h2', {}, text);
}

/** Returns a list that is opened by its title, and stays so from visit to visit; nothing for an empty one. */
function section(title: string, items: HTMLElement[], isOpen: boolean, count = items.length): HTMLElement[] {
  if (items.length === 0) return [];
  const key = `section.${title}`;
  const number = make('small', { class: 'quiet' }, count > 0 ? String(count) : '');
  const details = make('details', { class: 'section' }, make('summary', {}, heading(title), number));
  details.open = (remembered(key) ?? String(isOpen)) === 'true';
  details.ontoggle = () => remember(key, String(details.open));
  details.append(make('ul', { class: 'tree' }, ...items));
  return [details];
}
