/** The joints of the robot that is driven: a slider and a number for each, poses that are kept, and two buttons for a gripper. */

import { gripPoses, moversOf, nudged } from '../arm';
import type { Client } from '../protocol/client';
import type { RobotState } from '../protocol/frame';
import type { Gripper, Joint, RobotClass, Vector } from '../protocol/scene';
import { DEGREES } from '../values';
import { fixed, make, remember, remembered, repeat, setText } from './dom';

type JointState = RobotState['joints'][number];

/** Step of an arrow key, and steps of Page Up. */
const STEPS = { rad: 0.01, m: 0.0005 };
const PAGE = 10;
/** Digits after the point, and a second unit for people. */
const DIGITS = { rad: 3, m: 4 };
const IN_WORDS = {
  rad: (value: number) => `${fixed(DEGREES * value, 1)}°`,
  m: (value: number) => `${fixed(value * 1000, 1)} mm`,
};
/** Unit in which a person reads and types in place of radians, and whether that is chosen. */
const IN_DEGREES = { unit: '°', factor: DEGREES, digits: 1 };
let isInDegrees = remembered('angles') === 'degrees';
/** Poses of a class that are kept, at most. */
const MOST_POSES = 8;
/** Way of the hand at a press, m. */
const NUDGE = 0.01;
/** Ways of the hand along the robot's axes. */
const NUDGES: [string, string, Vector][] = [
  ['ahead', '↑', [1, 0, 0]],
  ['back', '↓', [-1, 0, 0]],
  ['left', '←', [0, -1, 0]],
  ['right', '→', [0, 1, 0]],
  ['up', '⤒', [0, 0, -1]],
  ['down', '⤓', [0, 0, 1]],
];
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
  private sliders: JointRow[] = [];
  private robotClass = '';
  /** Poses of the class's gripper. */
  private gripping: { name: string; pose: number[]; title: string }[] = [];
  private readonly poses = make('div', { class: 'row poses', role: 'group', 'aria-label': 'Poses' });
  private readonly units = make('button', { type: 'button', id: 'angle-unit', title: 'Angles in degrees or radians' });

  constructor() {
    this.units.onclick = () => {
      isInDegrees = !isInDegrees;
      remember('angles', isInDegrees ? 'degrees' : 'rad');
      this.showUnits();
    };
  }

  /** Shows the joints of a class; `client` returns the connection that moves them. */
  build(name: string, robotClass: RobotClass | null, client: () => Client | undefined): void {
    this.robotClass = name;
    const { joints = [], grippers = [] } = robotClass ?? {};
    const gripped = new Set(grippers.flatMap(({ joints }) => joints));
    const sliders = joints.flatMap((joint, index) =>
      gripped.has(joint.name) ? [] : [new JointRow(joint, index, (target) => client()?.setJoint(joint.name, target))],
    );
    const buttons = grippers.map((gripper) => {
      const indices = gripper.joints.map((name) => joints.findIndex((joint) => joint.name === name));
      return new GripperRow(gripper, indices, (opcode) => client()?.setGripper(gripper.name, opcode));
    });
    this.sliders = sliders;
    const { pick, carry } = robotClass ? gripPoses(robotClass) : { pick: null, carry: null };
    const ofSliders = (pose: number[]) => sliders.map(({ index }) => pose[index] ?? 0);
    this.gripping = [
      ...(pick ? [{ name: 'Pick', pose: ofSliders(pick), title: 'The gripper down, just above the floor ahead' }] : []),
      ...(carry ? [{ name: 'Carry', pose: ofSliders(carry), title: 'The gripper down, drawn in and raised' }] : []),
    ];
    this.rows = [...sliders, ...buttons];
    const head: HTMLElement[] = sliders.length > 0 ? [this.poses] : [];
    const link = grippers[0]?.link ?? null;
    if (robotClass && link !== null && moversOf(robotClass, link).length > 2) head.push(this.handRow(robotClass));
    this.element.replaceChildren(...head, ...this.rows.map(({ element }) => element));
    this.offerPoses();
    this.showUnits();
  }

  /** Buttons that move the hand. */
  private handRow(robotClass: RobotClass): HTMLElement {
    const buttons = NUDGES.map(([where, sign, way]) => {
      const title = `The hand ${where} by 1 cm; hold it for more`;
      const button = make('button', { type: 'button', class: 'icon', title, 'aria-label': `Hand ${where}` }, sign);
      repeat(button, () => {
        const positions = robotClass.joints.map(
          (_, index) => this.sliders.find((row) => row.index === index)?.aim ?? 0,
        );
        const next = nudged(robotClass, positions, way.map((part) => NUDGE * part) as Vector);
        if (next) this.sliders.forEach((row) => row.moveTo(next[row.index] ?? row.aim));
      });
      return button;
    });
    return make(
      'div',
      { class: 'row hand', role: 'group', 'aria-label': 'Hand' },
      make('span', {}, 'Hand'),
      ...buttons,
    );
  }

  private showUnits(): void {
    setText(this.units, isInDegrees ? 'Radians' : 'Degrees');
    this.sliders.forEach((row) => row.showUnit());
  }

  /** Offers the pose with all joints at 0, those of a gripper, and those that somebody kept for the class. */
  private offerPoses(): void {
    const kept = this.kept;
    const go = (name: string, pose: number[], title: string) => {
      const button = make('button', { type: 'button', title }, name);
      button.onclick = () => this.sliders.forEach((row, index) => row.moveTo(pose[index] ?? 0));
      return button;
    };
    const keep = make('button', { type: 'button', id: 'keep-pose', title: 'Keep this pose as a button' }, 'Keep pose');
    keep.onclick = () => {
      const poses = [...kept, this.sliders.map(({ position }) => Number(position.toFixed(4)))].slice(-MOST_POSES);
      remember(this.key, JSON.stringify(poses));
      this.offerPoses();
    };
    const poses = kept.map((pose, index) => go(`Pose ${index + 1}`, pose, pose.join(', ')));
    this.poses.replaceChildren(
      go('Home', [], 'All joints at 0, or as near as they come'),
      ...this.gripping.map(({ name, pose, title }) => go(name, pose, title)),
      ...poses,
      keep,
      this.units,
    );
  }

  private get key(): string {
    return `poses.${this.robotClass}`;
  }

  /** Poses of the class that this browser keeps: positions of the sliders' joints. */
  private get kept(): number[][] {
    try {
      const list: unknown = JSON.parse(remembered(this.key) ?? '[]');
      const isPose = (pose: unknown): pose is number[] =>
        Array.isArray(pose) && pose.length === this.sliders.length && pose.every(Number.isFinite);
      return Array.isArray(list) ? list.filter(isPose) : [];
    } catch {
      return [];
    }
  }

  /** Moves joints to positions, by their names. */
  moveJoints(positions: ReadonlyMap<string, number>): void {
    for (const row of this.sliders) {
      const position = positions.get(row.name);
      if (position !== undefined) row.moveTo(position);
    }
  }

  /** Follows the robot as it is shown; without one nothing can be moved. */
  update(robot: RobotState | null, mayMove: boolean): void {
    this.element.disabled = !mayMove || !robot;
    if (robot) this.rows.forEach((row) => row.follow(robot.joints));
  }
}

class JointRow {
  readonly element: HTMLElement;
  private readonly unitText = make('span', { class: 'quiet unit' });
  private readonly slider: HTMLInputElement;
  private readonly field: HTMLInputElement;
  private readonly step: number;
  private isHeld = false;
  position = 0;
  /** The last target of the joint, and its time, ms. */
  private target: { value: number; at: number } | null = null;

  constructor(
    private readonly joint: Joint,
    readonly index: number,
    private readonly send: (target: number) => void,
  ) {
    const { name, min, max } = joint;
    this.step = STEPS[this.unit];
    const [id, range] = [`joint-${name}`, { min: String(min), max: String(max), step: 'any' }];
    // The browser rounds a value by the limits that it has, so these come first.
    this.slider = make('input', { type: 'range', id, ...range });
    this.field = make('input', { type: 'number', id: `${id}-number`, step: 'any' });
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
      this.unitText,
    );
  }

  get name(): string {
    return this.joint.name;
  }

  /** Target of the joint, or its position if it has none. */
  get aim(): number {
    return this.target?.value ?? this.position;
  }

  /** Shows numbers in the unit that is chosen. */
  showUnit(): void {
    const { name, min, max } = this.joint;
    this.field.setAttribute('aria-label', `${name}, ${this.read.unit}`);
    [this.field.min, this.field.max] = [min, max].map((end) => String(end * this.read.factor)) as [string, string];
    setText(this.unitText, this.read.unit);
    if (document.activeElement !== this.field) this.field.value = this.shown(this.position);
  }

  /** Unit in which a person reads: its factor to the joint's own, and digits after the point. */
  private get read(): typeof IN_DEGREES {
    if (this.unit === 'rad' && isInDegrees) return IN_DEGREES;
    return { unit: this.unit, factor: 1, digits: DIGITS[this.unit] };
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
    return fixed(value * this.read.factor, this.read.digits);
  }

  private describe(value: number): void {
    this.slider.setAttribute('aria-valuetext', `${this.shown(value)} ${this.read.unit}`);
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
    this.moveTo(this.aim + steps * this.step);
    if (target === this.field && this.target) this.field.value = this.shown(this.target.value);
  }

  /** Takes what was typed. */
  private take(): void {
    if (this.field.value === '' || Number.isNaN(this.field.valueAsNumber)) this.field.value = this.shown(this.position);
    else {
      this.moveTo(this.field.valueAsNumber / this.read.factor);
      this.field.value = this.shown(this.target?.value ?? this.position);
    }
  }

  moveTo(wanted: number): void {
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
