/** What the pointer does in the view: a click chooses or places a robot, a drag of an own robot moves it while time stands still. */

import type { Vector } from '../protocol/scene';
import type { State } from '../state';
import type { View } from '../view/view';
import { find } from './dom';
import type { Placing } from './spawn';

/** A press that moves farther is no click, px. */
const CLICK_REACH = 5;

export class Pointer {
  private placing: Placing = null;
  private pressed: PointerEvent | null = null;
  private dragged: number | null = null;

  constructor(
    private readonly state: State,
    private readonly view: View,
    private readonly select: (robot: number) => void,
    private readonly move: (robot: number, place: Vector) => void,
  ) {
    const canvas = find('canvas');
    // Before the camera's own listener, which turns the view unless a robot is dragged.
    canvas.addEventListener('pointerdown', (event) => this.down(event), true);
    canvas.addEventListener('pointermove', (event) => this.over(event));
    canvas.addEventListener('pointerup', (event) => this.up(event));
    canvas.addEventListener('pointercancel', () => this.cancel());
    window.addEventListener('keydown', ({ key }) => key === 'Escape' && this.cancel());
  }

  /** Waits for a click that says where a robot is to stand; null ends that. */
  place(placing: Placing): void {
    this.placing = placing;
    find('view').classList.toggle('placing', placing !== null);
    if (!placing) this.view.showGhost(null);
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
    if (place && (this.placing || this.hasMoved(event))) this.view.showGhost(robotClass, place, 0);
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
      if (!place) return;
      this.place(null);
      placing.finish(place);
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
