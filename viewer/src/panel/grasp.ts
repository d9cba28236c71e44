/** Buttons that pull the chosen robot or object, for who has no pointer. */

import type { Vector } from '../protocol/scene';
import type { State } from '../state';
import { find, make, remember, remembered, repeat, setText } from './dom';
import { type Hands, TURN, type Thing } from './hands';

/** Way for a press, m, and turn, rad: at most the half of a metre and of a right angle in a second. */
const WAY = 0.05;
const ANGLE = 0.1;
const WAYS: [string, string, Vector, number][] = [
  ['along x', 'x+', [WAY, 0, 0], 0],
  ['against x', 'x−', [-WAY, 0, 0], 0],
  ['along y', 'y+', [0, WAY, 0], 0],
  ['against y', 'y−', [0, -WAY, 0], 0],
  ['up', '⤒', [0, 0, -WAY], 0],
  ['down', '⤓', [0, 0, WAY], 0],
  ['to the left', '↺', [0, 0, 0], -ANGLE],
  ['to the right', '↻', [0, 0, 0], ANGLE],
];
const SHOWN = 'grasp';

/** A thing that is held, the place to which it is pulled, its turn, rad, and true if time stood still when it was taken. */
interface Held {
  thing: Thing;
  to: Vector;
  turn: number;
  isPaused: boolean;
}

export class Grasp {
  private held: Held | null = null;
  private readonly element: HTMLDetailsElement;
  private readonly buttons: HTMLButtonElement[];
  private readonly end = make('button', { type: 'button', id: 'let-go', disabled: '' }, 'Let go');

  constructor(
    private readonly state: State,
    private readonly hands: Hands,
  ) {
    this.buttons = WAYS.map(([where, sign, way, turn]) => {
      const [verb, size] = turn === 0 ? ['Pull', '5 cm'] : ['Turn', '6°'];
      const attributes = { class: 'icon', title: `${verb} ${where} by ${size}; hold it for more` };
      const button = make('button', { type: 'button', ...attributes, 'aria-label': `${verb} ${where}` }, sign);
      repeat(button, () => this.press(way, turn));
      return button;
    });
    this.end.onclick = () => this.letGo();
    const row = make('div', { class: 'row hand', role: 'group', 'aria-label': 'Pull' }, ...this.buttons, this.end);
    this.element = make('details', { id: 'grasp', hidden: '' }, make('summary', {}, 'Pull by buttons'), row);
    this.element.open = remembered(SHOWN) === 'true';
    this.element.ontoggle = () => remember(SHOWN, String(this.element.open));
    find('drive').append(this.element);
  }

  /** Shows the buttons and gives the first one the focus. Returns false if nothing is chosen that may be pulled. */
  open(): boolean {
    this.update();
    if (this.element.hidden) return false;
    this.element.open = true;
    this.buttons[0]?.focus();
    return true;
  }

  /** Shows what may be done now; to be called a few times a second. What is no longer chosen is let go. */
  update(): void {
    const { held, hands } = this;
    if (held && !(hands.mayAct && hands.isChosen(held.thing) && hands.holds(held.thing))) this.letGo();
    this.element.hidden = !hands.chosen || !hands.mayAct;
    this.end.disabled = this.held === null;
    if (this.element.hidden) return;
    setText(this.end, this.held?.isPaused ? 'Done' : 'Let go');
  }

  private press(way: Vector, turn: number): void {
    const held = this.holdChosen();
    if (!held) return;
    held.to = held.to.map((at, axis) => at + (way[axis] ?? 0)) as Vector;
    held.turn += turn;
    this.hands.pull(held.to, held.turn / TURN);
    this.update();
  }

  /** Returns the chosen thing as it is held, and takes it if it is not, or was taken before time was stopped or went on. */
  private holdChosen(): Held | null {
    const [{ held, hands }, thing, isPaused] = [this, this.hands.chosen, this.state.status?.paused === true];
    if (!thing) return null;
    if (held && held.isPaused === isPaused && hands.isChosen(held.thing) && hands.holds(thing)) return held;
    const to = hands.placeOf(thing);
    this.held = to && hands.take(thing, to) ? { thing, to, turn: 0, isPaused } : null;
    return this.held;
  }

  private letGo(): void {
    if (this.held && this.hands.holds(this.held.thing)) this.hands.release();
    this.held = null;
    this.end.disabled = true;
  }
}
