/**
 * Pointer in the view: a click chooses a thing or places a robot. A drag on the chosen thing pulls it, moves it while time stands still, or
 * leads its arm. A finger first rests on it; if it goes without having moved, it asks for the menu.
 */

import type { Fit, FitAnswer } from '../protocol/fit';
import type { Vector } from '../protocol/scene';
import type { State } from '../state';
import type { Hit, View } from '../view/view';
import { find, setText } from './dom';
import type { Hands, Thing } from './hands';
import type { Leading } from './leading';
import { type Placing, spawnPlace } from './spawn';

/** A press that moves farther is no click, px. */
const CLICK_REACH = 5;

/** Time after which a finger that rests on a thing has it, ms. */
const REST = 450;

/** Two places that are nearer are one, m. */
const SAME = 0.002;

export class Pointer {
  private placing: Placing = null;
  private pressed: PointerEvent | null = null;
  /** A finger that may come to rest, and true once it has. */
  private resting: ReturnType<typeof setTimeout> | undefined;
  private hasRested = false;
  /** True while a second finger lifts what the first one has. */
  private isLifting = false;
  /** The thing in the hand. */
  private dragged: Thing | null = null;
  /** Place to which it is pulled. */
  private to: Vector | null = null;
  /** Way of the pointer to the side with Ctrl, and its last place across, px. */
  private turned = 0;
  private last = 0;
  /** Place of the ghost, and the server's last answer. */
  private shown: Vector | null = null;
  private answer: FitAnswer | null = null;
  private readonly canvas = find('canvas');
  private readonly hint = find('placing');

  constructor(
    private readonly state: State,
    private readonly view: View,
    private readonly hands: Hands,
    private readonly leading: Leading,
    private readonly choose: (thing: Thing | null) => void,
    private readonly menu: (hit: Hit, x: number, y: number) => void,
    private readonly askFit: (fit: Fit) => void,
  ) {
    const { canvas } = this;
    // Before the camera's own listener, which turns the view unless a robot is dragged.
    canvas.addEventListener('pointerdown', (event) => this.down(event), true);
    canvas.addEventListener('pointermove', (event) => this.over(event));
    canvas.addEventListener('pointerup', (event) => this.up(event));
    canvas.addEventListener('pointercancel', () => this.cancel());
    window.addEventListener('keydown', ({ key }) => key === 'Escape' && this.cancel());
    window.addEventListener('blur', () => this.dragged && this.cancel());
  }

  /** Waits for a click that says where a robot shall stand; null ends that. */
  place(placing: Placing): void {
    this.placing = placing;
    this.shown = this.answer = null;
    find('view').classList.toggle('placing', placing !== null);
    this.hint.hidden = placing === null;
    this.showHint();
    if (!placing) this.view.showGhost(null);
  }

  /** Takes the server's answer for a place, which the pointer may have left. */
  takeFit(answer: FitAnswer): void {
    if (!this.placing) return;
    this.answer = answer;
    if (this.shown) this.showGhost(this.placing.robotClass, this.shown);
    this.showHint();
  }

  /** Shows the robot that is placed; the last answer colours it until the next one comes. */
  private showGhost(robotClass: string, place: Vector): void {
    this.view.showGhost(robotClass, place, 0, this.answer?.stands ?? true);
  }

  private showHint(): void {
    const { answer } = this;
    const why = answer?.why ? `: ${answer.why}` : '';
    const isRefused = answer !== null && !answer.stands;
    this.hint.dataset.stands = answer ? String(answer.stands) : 'unknown';
    this.hint.classList.toggle('refused', isRefused);
    const text = isRefused ? `⚠ A robot cannot stand here${why}` : 'Click where the robot should stand; Esc to cancel';
    setText(this.hint, text);
  }

  /** True if the server said that a robot cannot stand at a place. */
  private isRefused(place: Vector): boolean {
    if (!this.answer || this.answer.stands) return false;
    return this.answer.location.every((at, axis) => Math.abs(at - (spawnPlace(place)[axis] ?? 0)) < SAME);
  }

  private down(event: PointerEvent): void {
    clearTimeout(this.resting);
    if (this.dragged) {
      this.isLifting = true;
      return;
    }
    this.pressed = event;
    this.hasRested = false;
    if (event.button !== 0 || this.placing) return;
    // A finger that moves at once turns the view.
    if (event.pointerType === 'touch') this.resting = setTimeout(() => this.rest(event), REST);
    else this.take(this.pick(event), event);
  }

  private pick({ clientX: x, clientY: y }: PointerEvent): Hit | null {
    return this.view.pick(x, y);
  }

  /** A finger rests on a thing: it is chosen, and taken. */
  private rest(event: PointerEvent): void {
    const hit = this.pick(event);
    if (!hit) return;
    this.hasRested = true;
    this.canvas.classList.add('grabbing');
    navigator.vibrate?.(15);
    if (!('ground' in hit) && !this.hands.isChosen(hit)) this.choose(hit);
    this.take(hit, event);
  }

  /** Takes the chosen thing, if that is what was hit. */
  private take(hit: Hit | null, event: PointerEvent): void {
    if (!hit || 'ground' in hit || !this.hands.isChosen(hit)) return;
    if (!this.leading.take(hit) && !this.hands.take(hit, hit.place)) return;
    this.dragged = hit;
    this.to = hit.place;
    this.turned = 0;
    this.last = event.clientX;
    this.view.holdCamera(true);
    this.canvas.classList.add('grabbing');
    this.canvas.setPointerCapture(event.pointerId);
  }

  private over(event: PointerEvent): void {
    if (this.hasMoved(event)) clearTimeout(this.resting);
    if (this.dragged) return this.drag(event);
    if (!this.placing) return;
    const place = this.view.groundAt(event.clientX, event.clientY);
    if (!place) return;
    this.shown = place;
    this.showGhost(this.placing.robotClass, place);
    this.askFit({ class: this.placing.robotClass, location: spawnPlace(place), yaw: 0 });
  }

  /** Pulls in the plane of the floor; with Shift or a second finger up and down, and with Ctrl about the vertical. */
  private drag(event: PointerEvent): void {
    const { clientX: x, clientY: y, ctrlKey: isTurning } = event;
    const isLifting = event.shiftKey || this.isLifting;
    if (!this.dragged || !this.to || this.isOther(event) || !this.hasMoved(event)) return;
    if (this.isPut) {
      const place = this.view.groundAt(x, y);
      if (place) this.view.showGhost(this.state.robot(this.robot)?.class ?? null, place);
      return;
    }
    if (isTurning) this.turned += x - this.last;
    else this.to = this.view.pointAt(x, y, this.to, isLifting) ?? this.to;
    this.last = x;
    if (this.leading.isOn) this.leading.lead(this.to, this.turned);
    else this.hands.pull(this.to, this.turned);
  }

  private get robot(): number | null {
    return this.dragged && 'robot' in this.dragged ? this.dragged.robot : null;
  }

  /** True if what is dragged is put down where it is let go: a robot needs room. */
  private get isPut(): boolean {
    return this.robot !== null && !this.leading.isOn && this.state.status?.paused === true;
  }

  private up(event: PointerEvent): void {
    clearTimeout(this.resting);
    if (this.dragged && this.isOther(event)) {
      this.isLifting = false;
      return;
    }
    this.canvas.classList.remove('grabbing');
    if (this.dragged && this.hasMoved(event)) {
      const place = this.isPut ? this.view.groundAt(event.clientX, event.clientY) : null;
      if (place) this.hands.putDown(place);
      else this.hands.release();
      return this.letGo();
    }
    if (this.dragged) this.cancel();
    if (this.hasMoved(event)) return;
    const { placing } = this;
    if (placing) {
      const place = this.view.groundAt(event.clientX, event.clientY);
      if (!place || this.isRefused(place)) return;
      this.place(null);
      placing.finish(spawnPlace(place));
      return;
    }
    const hit = this.pick(event);
    if ((event.button === 2 || this.hasRested) && hit) this.menu(hit, event.clientX, event.clientY);
    else if (event.button === 0) this.choose(hit && !('ground' in hit) ? hit : null);
  }

  private cancel(): void {
    clearTimeout(this.resting);
    this.canvas.classList.remove('grabbing');
    this.hands.release();
    this.letGo();
    this.place(null);
  }

  private letGo(): void {
    this.leading.release();
    this.isLifting = false;
    this.dragged = this.to = null;
    this.view.showGhost(null);
    this.view.holdCamera(false);
  }

  /** True if an event is of another finger than the one that has the thing. */
  private isOther(event: PointerEvent): boolean {
    return event.pointerId !== this.pressed?.pointerId;
  }

  private hasMoved({ clientX, clientY }: PointerEvent): boolean {
    return (
      this.pressed === null || Math.hypot(clientX - this.pressed.clientX, clientY - this.pressed.clientY) > CLICK_REACH
    );
  }
}
