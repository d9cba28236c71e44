/** Pointer in the view: a click chooses or places a robot. A drag moves an own robot while time stands still. */

import type { Fit, FitAnswer } from '../protocol/fit';
import type { Vector } from '../protocol/scene';
import type { State } from '../state';
import type { View } from '../view/view';
import { find, setText } from './dom';
import type { Placing } from './spawn';

/** A press that moves farther is no click, px. */
const CLICK_REACH = 5;

/** Two places that are nearer are one, m. */
const SAME = 0.002;

export class Pointer {
  private placing: Placing = null;
  private pressed: PointerEvent | null = null;
  private dragged: number | null = null;
  /** Place of the ghost, and the server's last answer. */
  private shown: Vector | null = null;
  private answer: FitAnswer | null = null;
  private readonly hint = find('placing');

  constructor(
    private readonly state: State,
    private readonly view: View,
    private readonly select: (robot: number) => void,
    private readonly move: (robot: number, place: Vector) => void,
    private readonly askFit: (fit: Fit) => void,
  ) {
    const canvas = find('canvas');
    // Before the camera's own listener, which turns the view unless a robot is dragged.
    canvas.addEventListener('pointerdown', (event) => this.down(event), true);
    canvas.addEventListener('pointermove', (event) => this.over(event));
    canvas.addEventListener('pointerup', (event) => this.up(event));
    canvas.addEventListener('pointercancel', () => this.cancel());
    window.addEventListener('keydown', ({ key }) => key === 'Escape' && this.cancel());
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
    this.pressed = event;
    const hit = event.button === 0 && !this.placing ? this.view.pick(event.clientX, event.clientY) : null;
    if (!hit || !('robot' in hit) || !this.state.status?.paused || !this.state.isPresent) return;
    const robot = this.state.robot(hit.robot);
    if (!robot || !this.state.isOwn(robot)) return;
    this.dragged = hit.robot;
    this.view.holdCamera(true);
    find('canvas').setPointerCapture(event.pointerId);
  }

  private over(event: PointerEvent): void {
    if (this.dragged === null && !this.placing) return;
    const place = this.view.groundAt(event.clientX, event.clientY);
    const robotClass = this.placing?.robotClass ?? this.state.robot(this.dragged)?.class ?? null;
    if (!place) return;
    if (this.placing) {
      this.shown = place;
      this.showGhost(this.placing.robotClass, place);
      this.askFit({ class: this.placing.robotClass, location: spawnPlace(place), yaw: 0 });
    } else if (this.hasMoved(event)) this.view.showGhost(robotClass, place, 0);
  }

  private up(event: PointerEvent): void {
    const dragged = this.dragged;
    this.dragged = null;
    if (dragged !== null) this.letGo();
    if (this.hasMoved(event)) {
      const place = dragged === null ? null : this.view.groundAt(event.clientX, event.clientY);
      if (dragged !== null && place) this.move(dragged, place);
      return;
    }
    const { placing } = this;
    if (placing) {
      const place = this.view.groundAt(event.clientX, event.clientY);
      if (!place || this.isRefused(place)) return;
      this.place(null);
      placing.finish(spawnPlace(place));
      return;
    }
    const hit = this.view.pick(event.clientX, event.clientY);
    if (hit && 'robot' in hit) this.select(hit.robot);
  }

  private cancel(): void {
    this.dragged = null;
    this.letGo();
    this.place(null);
  }

  private letGo(): void {
    this.view.showGhost(null);
    this.view.holdCamera(false);
  }

  private hasMoved({ clientX, clientY }: PointerEvent): boolean {
    return (
      this.pressed === null || Math.hypot(clientX - this.pressed.clientX, clientY - this.pressed.clientY) > CLICK_REACH
    );
  }
}

/** A little above the ground, on which the robot is put down. */
function spawnPlace([x, y, z]: Vector): Vector {
  return [x, y, z - 0.01];
}
