/** The form that spawns a robot: it offers a start without a robot, and a name that no robot has. */

import { type Start, classesOf, firstClasses, startsOf } from '../offer';
import type { Spawn } from '../protocol/client';
import type { Vector } from '../protocol/scene';
import type { State } from '../state';
import { find, make, setText } from './dom';
import { focusView } from './keys';

/** A start is taken by a robot that is nearer than this, m. */
const TAKEN_DISTANCE = 1;
const FIRST_NAME = 'Robot1';

/** Purpose of a click on the map: a robot of a class. */
export type Placing = { robotClass: string; finish: (place: Vector) => void } | null;

export class SpawnForm {
  private readonly classes = make('select', { name: 'class' });
  private readonly starts = make('select', { name: 'start' });
  private readonly startsTitle = make('span', {});
  /** The starts that are offered, in the order of their options. */
  private offered: Start[] = [];
  private readonly name = make('input', {
    name: 'name',
    value: FIRST_NAME,
    maxlength: '40',
    autocomplete: 'off',
    'aria-describedby': 'name-hint',
  });
  private readonly hint = make('p', { class: 'hint', id: 'name-hint', role: 'status' });
  /** True if a person has chosen or typed it: then it is not replaced. */
  private classIsChosen = false;
  private startIsChosen = false;
  private nameIsTyped = false;
  /** Robots that are not in the world yet. */
  private expected: Spawn[] = [];

  constructor(
    private readonly state: State,
    private readonly place: (placing: Placing) => void,
    private readonly spawn: (spawn: Spawn) => void,
    /** Hears which class may be spawned next. */
    private readonly chosen: (robotClass: string) => void,
  ) {
    const form = make(
      'form',
      {},
      make('h2', {}, 'Spawn a robot'),
      make('label', {}, 'Class', this.classes),
      make('label', {}, this.startsTitle, this.starts),
      make('label', {}, 'Name', this.name),
      this.hint,
      make('div', { class: 'row' }, make('button', { type: 'submit', id: 'spawn' }, 'Spawn')),
    );
    this.classes.onchange = () => this.setClass(this.classes.value);
    this.starts.onchange = () => (this.startIsChosen = true);
    this.name.oninput = () => (this.nameIsTyped = true);
    form.onsubmit = (event) => {
      event.preventDefault();
      this.submit();
    };
    find('drive').append(form);
  }

  /** Offers the classes and starts of another world. */
  updateScene(): void {
    const { scene } = this.state;
    if (!scene) return;
    const possible = classesOf(scene);
    const isKept = this.classIsChosen && possible.includes(this.classes.value);
    const robotClass = isKept ? this.classes.value : (firstClasses(scene)[0] ?? '');
    this.classes.replaceChildren(...possible.map((name) => make('option', { value: name }, name)));
    this.classes.value = robotClass;
    this.startIsChosen = false;
    this.offerStarts();
  }

  /** Class that is offered. */
  get robotClass(): string {
    return this.classes.value;
  }

  private setClass(robotClass: string): void {
    this.classes.value = robotClass;
    this.classIsChosen = true;
    this.offerStarts();
  }

  /** Lists the starts of the chosen class; a league has no others. */
  private offerStarts(): void {
    const { scene } = this.state;
    if (!scene) return;
    this.chosen(this.classes.value);
    const before = this.starts.value;
    this.offered = startsOf(scene, this.classes.value);
    setText(this.startsTitle, scene.league ? 'Team' : 'Start');
    this.starts.replaceChildren(
      ...this.offered.map(({ label }) => make('option', { value: label }, label)),
      ...(scene.league ? [] : [make('option', { value: '' }, 'where you click on the map')]),
    );
    const isKept = this.startIsChosen && [...this.starts.options].some(({ value }) => value === before);
    this.startIsChosen = isKept;
    if (isKept) this.starts.value = before;
    this.update(this.expected);
  }

  /** Marks the starts that are taken and offers what is free; `expected` are robots that are not in the world yet. */
  update(expected: Spawn[]): void {
    this.expected = expected;
    const robots = (this.state.frame?.robots ?? []).map(({ pose }) => pose);
    const occupied = [...robots, ...expected.map((spawn) => this.location(spawn))];
    const free = this.offered.filter(
      ({ position: [x, y], team }) =>
        (team === null || this.hasRoom(team, expected)) &&
        occupied.every((place) => !place || Math.hypot(place[0] - x, place[1] - y) >= TAKEN_DISTANCE),
    );
    for (const [index, start] of this.offered.entries()) {
      const option = this.starts.options[index];
      if (option) setText(option, free.includes(start) ? start.label : `${start.label} (taken)`);
    }
    if (!this.startIsChosen && document.activeElement !== this.starts) {
      this.starts.value = free[0]?.label ?? '';
      // A league has no other places: the server says then what can be done.
      if (this.starts.selectedIndex < 0) this.starts.selectedIndex = 0;
    }

    const names = [...(this.state.status?.robots ?? []), ...expected].map(({ name }) => name);
    if (!this.nameIsTyped) this.name.value = freeName(this.name.value, names);
    setText(this.hint, this.nameHint(names));
  }

  /** Warns of a name that will be changed or is taken. */
  private nameHint(taken: string[]): string {
    const name = this.wireName();
    const changed = this.name.value !== name && this.name.value !== '';
    const hints = [
      ...(changed ? [`It will be named ${name}: a name has no spaces and no braces.`] : []),
      ...(taken.includes(name) ? [`There is a robot named ${name} already.`] : []),
    ];
    return hints.join(' ');
  }

  focus(): void {
    this.classes.focus();
  }

  /** Offers the name of a robot that was refused again. */
  offerName(name: string): void {
    if (!this.nameIsTyped) this.name.value = name;
  }

  /** Chooses a class, and a place if one is given, and presses the button for a person. */
  choose(robotClass: string, location: Vector | null = null): void {
    this.setClass(robotClass);
    if (!location) return this.submit();
    focusView();
    this.place(null);
    this.finish({ location, yaw: 0 }, null);
  }

  private submit(): void {
    // The keys drive from now on.
    focusView();
    this.place(null);
    const start = this.offered.find(({ label }) => label === this.starts.value);
    if (start) this.finish({ start: start.name }, start.team);
    else {
      const finish = (location: Vector) => this.finish({ location, yaw: 0 }, null);
      this.place({ robotClass: this.classes.value, finish });
    }
  }

  private finish(place: Spawn['place'], team: string | null): void {
    // Who clicks on the map is asked to click for the next one, too.
    this.startIsChosen &&= this.starts.value === '';
    const name = this.wireName();
    this.name.value = name;
    this.nameIsTyped = false;
    this.spawn({ robotClass: this.classes.value, name, place, team });
  }

  /** True if a team may have one more robot: as many as it has starts. */
  private hasRoom(team: string, expected: Spawn[]): boolean {
    const { status, scene } = this.state;
    const present = new Set(status?.robots.map(({ id }) => id));
    const entered = status?.league?.teams.find(({ name }) => name === team)?.robots ?? [];
    const robots = entered.filter((id) => present.has(id)).length;
    const waiting = expected.filter((spawn) => spawn.team === team).length;
    const starts = scene?.league?.teams.find(({ name }) => name === team)?.starts ?? [];
    return robots + waiting < starts.length;
  }

  private location({ place, team }: Spawn): Vector | undefined {
    if (!('start' in place)) return place.location;
    return this.offered.find((start) => start.name === place.start && start.team === team)?.position;
  }

  /** A name on the wire has no white space and no braces. */
  private wireName(): string {
    return this.name.value.replace(/[\s{}]+/g, '_') || FIRST_NAME;
  }
}

/** The name itself, or with the first higher number that makes it free. */
function freeName(name: string, taken: string[]): string {
  // Nine digits: more may not be counted up exactly.
  const [, stem = '', number = ''] = /^(.*?)(\d{0,9})$/.exec(name) ?? [];
  for (let next = Number(number || 1) + 1; taken.includes(name); next++) name = `${stem}${next}`;
  return name;
}

/** A little above the ground, on which it is put down. */
export function spawnPlace([x, y, z]: Vector): Vector {
  return [x, y, z - 0.01];
}
