/** The form that spawns a robot: it offers a start without a robot, and a name that no robot has. */

import type { Spawn } from '../protocol/client';
import type { NamedPlace, Vector } from '../protocol/scene';
import type { State } from '../state';
import { find, make, setText } from './dom';
import { focusView } from './keys';

/** A start is taken by a robot that is nearer than this, m. */
const TAKEN_DISTANCE = 1;
const FIRST_CLASS = 'YouBotArm';
const FIRST_NAME = 'Robot1';

/** Purpose of a click on the map: a robot of a class. */
export type Placing = { robotClass: string; finish: (place: Vector) => void } | null;

export class SpawnForm {
  private readonly classes = make('select', { name: 'class' });
  private readonly starts = make('select', { name: 'start' });
  private readonly name = make('input', {
    name: 'name',
    value: FIRST_NAME,
    maxlength: '40',
    autocomplete: 'off',
    'aria-describedby': 'name-hint',
  });
  private readonly hint = make('p', { class: 'hint', id: 'name-hint', role: 'status' });
  /** What a person has chosen or typed is not replaced. */
  private startIsChosen = false;
  private nameIsTyped = false;

  constructor(
    private readonly state: State,
    private readonly place: (placing: Placing) => void,
    private readonly spawn: (spawn: Spawn) => void,
  ) {
    const form = make(
      'form',
      {},
      make('h2', {}, 'Spawn a robot'),
      make('label', {}, 'Class', this.classes),
      make('label', {}, 'Start', this.starts),
      make('label', {}, 'Name', this.name),
      this.hint,
      make('div', { class: 'row' }, make('button', { type: 'submit', id: 'spawn' }, 'Spawn')),
    );
    this.starts.onchange = () => (this.startIsChosen = true);
    this.name.oninput = () => (this.nameIsTyped = true);
    form.onsubmit = (event) => {
      event.preventDefault();
      this.submit();
    };
    find('drive').append(form);
  }

  /** Another world: its classes and its places. */
  updateScene(): void {
    const { scene } = this.state;
    if (!scene) return;
    const keep = this.classes.value || FIRST_CLASS;
    this.classes.replaceChildren(...Object.keys(scene.classes).map((name) => make('option', { value: name }, name)));
    if (scene.classes[keep]) this.classes.value = keep;
    this.starts.replaceChildren(
      ...scene.map.starts.map(({ name }) => make('option', { value: name }, name)),
      make('option', { value: '' }, 'where you click on the map'),
    );
    this.startIsChosen = false;
  }

  /** Marks the starts that are taken and offers what is free; `expected` are robots that are not in the world yet. */
  update(expected: Spawn[]): void {
    const starts = this.state.scene?.map.starts ?? [];
    const robots = (this.state.frame?.robots ?? []).map(({ pose }) => pose);
    const occupied = [...robots, ...expected.map((spawn) => location(spawn, starts))];
    const free = starts.filter(({ position: [x, y] }) =>
      occupied.every((place) => !place || Math.hypot(place[0] - x, place[1] - y) >= TAKEN_DISTANCE),
    );
    for (const [index, start] of starts.entries()) {
      const option = this.starts.options[index];
      if (option) setText(option, free.includes(start) ? start.name : `${start.name} (taken)`);
    }
    if (!this.startIsChosen && document.activeElement !== this.starts) this.starts.value = free[0]?.name ?? '';

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

  /** As if a person had chosen a class and pressed the button. */
  choose(robotClass: string): void {
    this.classes.value = robotClass;
    this.submit();
  }

  private submit(): void {
    // The keys drive from now on.
    focusView();
    this.place(null);
    const start = this.starts.value;
    if (start) this.finish({ start });
    else {
      const finish = (location: Vector) => this.finish({ location, yaw: 0 });
      this.place({ robotClass: this.classes.value, finish });
    }
  }

  private finish(place: Spawn['place']): void {
    // Who clicks on the map is asked to click for the next one, too.
    this.startIsChosen &&= this.starts.value === '';
    const name = this.wireName();
    this.name.value = name;
    this.nameIsTyped = false;
    this.spawn({ robotClass: this.classes.value, name, place });
  }

  /** A name on the wire has no white space and no braces. */
  private wireName(): string {
    return this.name.value.replace(/[\s{}]+/g, '_') || FIRST_NAME;
  }
}

function location({ place }: Spawn, starts: NamedPlace[]): Vector | undefined {
  return 'start' in place ? starts.find(({ name }) => name === place.start)?.position : place.location;
}

/** The name itself, or with the first higher number that makes it free. */
function freeName(name: string, taken: string[]): string {
  // Nine digits: more may not be counted up exactly.
  const [, stem = '', number = ''] = /^(.*?)(\d{0,9})$/.exec(name) ?? [];
  for (let next = Number(number || 1) + 1; taken.includes(name); next++) name = `${stem}${next}`;
  return name;
}
