/** The joints of the robot that is driven: a slider and a number for each, and two buttons for a gripper. */

import type { Client } from '../protocol/client';
import type { RobotState } from '../protocol/frame';
import type { Gripper, Joint, RobotClass } from '../protocol/scene';
import { fixed, make, setText } from './dom';

type JointState = RobotState['joints'][number];

/** Step of an arrow key, and steps of Page Up. */
const STEPS = { rad: 0.01, m: 0.0005 };
const PAGE = 10;
/** Digits after the point, and a second unit for people. */
const DIGITS = { rad: 3, m: 4 };
const IN_WORDS = {
  rad: (value: number) => `${fixed((value * 180) / Math.PI, 1)}°`,
  m: (value: number) => `${fixed(value * 1000, 1)} mm`,
};
/** A joint that stands farther than so many steps from its target has been stopped or moved by something else. */
const ASTRAY = 20;
/** Slower than this a joint stands, steps a second. */
const STILL = 2;
/** A joint gets so long to start moving, ms. */
const START_TIME = 500;
const KEYS: Record<string, number> = {
  ArrowUp: 1,
  ArrowRight: 1,
  ArrowDown: -1,
  ArrowLeft: -1,
  PageUp: PAGE,
  PageDown: -PAGE,
};

export class JointsPanel {
  readonly element = make('fieldset', { 'data-joints': '', 'aria-label': 'Joints', class: 'plain' });
  private rows: (JointRow | GripperRow)[] = [];

  /** Shows the joints of a class; `client` returns the connection that moves them. */
  build(robotClass: RobotClass | null, client: () => Client | undefined): void {
    const { joints = [], grippers = [] } = robotClass ?? {};
    const gripped = new Set(grippers.flatMap(({ joints }) => joints));
    const sliders = joints.flatMap((joint, index) =>
      gripped.has(joint.name) ? [] : [new JointRow(joint, index, (target) => client()?.setJoint(joint.name, target))],
    );
    const buttons = grippers.map((gripper) => {
      const indices = gripper.joints.map((name) => joints.findIndex((joint) => joint.name === name));
      return new GripperRow(gripper, indices, (opcode) => client()?.setGripper(gripper.name, opcode));
    });
    this.rows = [...sliders, ...buttons];
    this.element.replaceChildren(...this.rows.map(({ element }) => element));
  }

  /** Follows the robot as it is shown; without one nothing can be moved. */
  update(robot: RobotState | null, mayMove: boolean): void {
    this.element.disabled = !mayMove || !robot;
    if (robot) this.rows.forEach((row) => row.follow(robot.joints));
  }
}

class JointRow {
  readonly element: HTMLElement;
  private readonly slider: HTMLInputElement;
  private readonly field: HTMLInputElement;
  private readonly step: number;
  private isHeld = false;
  private position = 0;
  /** The last target of the joint, and its time, ms. */
  private target: { value: number; at: number } | null = null;

  constructor(
    private readonly joint: Joint,
    private readonly index: number,
    private readonly send: (target: number) => void,
  ) {
    const { name, min, max } = joint;
    this.step = STEPS[this.unit];
    const [id, range] = [`joint-${name}`, { min: String(min), max: String(max), step: 'any' }];
    // The browser rounds a value by the limits that it has, so these come first.
    this.slider = make('input', { type: 'range', id, ...range });
    this.field = make('input', { type: 'number', id: `${id}-number`, 'aria-label': `${name}, ${this.unit}`, ...range });
    this.slider.oninput = () => this.moveTo(Number(this.slider.value));
    this.slider.onpointerdown = () => (this.isHeld = true);
    this.slider.onpointerup = this.slider.onpointercancel = this.slider.onblur = () => (this.isHeld = false);
    this.slider.onkeydown = (event) => this.key(event);
    this.field.onkeydown = (event) => this.key(event);
    this.field.onchange = () => this.take();
    this.element = make(
      'div',
      { class: 'row joint' },
      make('label', { for: id }, name),
      this.slider,
      this.field,
      make('span', { class: 'quiet unit' }, this.unit),
    );
  }

  follow(joints: JointState[]): void {
    const joint = joints[this.index];
    if (!joint) return;
    this.position = joint.position;
    this.forgetTarget(joint);
    if (!this.isHeld) this.slider.value = String(joint.position);
    this.describe(joint.position);
    if (document.activeElement !== this.field) this.field.value = this.shown(joint.position);
  }

  private get unit(): Joint['unit'] {
    return this.joint.unit;
  }

  private shown(value: number): string {
    return fixed(value, DIGITS[this.unit]);
  }

  private describe(value: number): void {
    this.slider.setAttribute('aria-valuetext', `${this.shown(value)} ${this.unit}`);
    this.slider.title = this.field.title = IN_WORDS[this.unit](value);
  }

  /** Small steps start at the target, or at the joint if something stopped it on its way. */
  private forgetTarget({ position, speed }: JointState): void {
    if (!this.target || performance.now() - this.target.at < START_TIME) return;
    const isAstray = Math.abs(position - this.target.value) > ASTRAY * this.step;
    if (isAstray && Math.abs(speed) < STILL * this.step) this.target = null;
  }

  private key(event: KeyboardEvent): void {
    const { key, target } = event;
    if (key === 'Escape' && target === this.field) {
      this.field.value = this.shown(this.position);
      this.field.blur();
    }
    const steps = KEYS[key];
    const movesCaret = target === this.field && (key === 'ArrowLeft' || key === 'ArrowRight');
    if ((steps === undefined && key !== 'End') || movesCaret || (key === 'End' && target === this.field)) return;
    // By itself the browser moves a hundredth of the range, or by `End` all of it.
    event.preventDefault();
    if (steps === undefined) return;
    this.moveTo((this.target?.value ?? this.position) + steps * this.step);
    if (target === this.field && this.target) this.field.value = this.shown(this.target.value);
  }

  /** Takes what was typed. */
  private take(): void {
    if (this.field.value === '' || Number.isNaN(this.field.valueAsNumber)) this.field.value = this.shown(this.position);
    else {
      this.moveTo(this.field.valueAsNumber);
      this.field.value = this.shown(this.target?.value ?? this.position);
    }
  }

  private moveTo(wanted: number): void {
    const value = Math.max(this.joint.min, Math.min(this.joint.max, wanted));
    this.target = { value, at: performance.now() };
    this.send(value);
  }
}

class GripperRow {
  readonly element: HTMLElement;
  private readonly state = make('span', { class: 'quiet' });

  constructor(
    private readonly gripper: Gripper,
    private readonly indices: number[],
    send: (opcode: 'Open' | 'Close') => void,
  ) {
    const button = (opcode: 'Open' | 'Close') => {
      const element = make('button', { type: 'button', 'data-grip': opcode }, opcode);
      element.onclick = () => send(opcode);
      return element;
    };
    const { name } = gripper;
    this.element = make(
      'div',
      { class: 'row joint', role: 'group', 'aria-label': name },
      make('span', { class: 'name' }, name),
      button('Open'),
      button('Close'),
      this.state,
    );
  }

  follow(joints: JointState[]): void {
    const { open, closed } = this.gripper;
    const parts = this.indices.flatMap((index, finger) => {
      const [from = 0, to = 0] = [closed[finger], open[finger]];
      const position = joints[index]?.position;
      return position === undefined || from === to ? [] : [(position - from) / (to - from)];
    });
    if (parts.length === 0) return;
    const part = parts.reduce((sum, part) => sum + part, 0) / parts.length;
    setText(this.state, `${fixed(100 * Math.max(0, Math.min(1, part)), 0)} % open`);
  }
}
