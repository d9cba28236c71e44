/** Words over the picture that never cover each other, nor show through walls and robots: the nearest comes first. */

import * as THREE from 'three';
import './view.css';

/** The colour of a robot, and the line that a label does not cover. */
export interface Manner {
  colour?: string;
  along?: THREE.Vector3;
}

export type LabelKind = 'pull' | 'robot' | 'start' | 'node' | 'object' | 'goal' | 'metres';

interface Label {
  element: HTMLElement;
  kind: LabelKind;
  /** Place on the stage. */
  place: THREE.Vector3;
  /** Direction of the line beside which it stands. */
  along: THREE.Vector3 | null;
  width: number;
  hidden: boolean;
  /** Time of its last test for walls and robots in front of it. */
  looked: number;
  behind: boolean;
  shown: number;
}

/** Farther than so many metres it is not shown; the first is where it begins to fade. */
const RANGE: Record<LabelKind, [number, number]> = {
  pull: [60, 90],
  robot: [35, 60],
  start: [7, 11],
  node: [6, 9],
  object: [7, 11],
  goal: [20, 30],
  metres: [60, 90],
};
/** Priority of labels that overlap. */
const ORDER: Record<LabelKind, number> = {
  pull: -1,
  robot: 0,
  goal: 40,
  object: 60,
  start: 80,
  node: 120,
  metres: 200,
};
const HEIGHT: Record<LabelKind, number> = {
  pull: 16,
  robot: 18,
  start: 16,
  node: 16,
  object: 16,
  goal: 16,
  metres: 14,
};
/** Distance of a robot's name above its place, px. */
const LEADER = 14;
/** Distance of a number from its axis, px. */
const ASIDE = 4;
/** Room of the dot before a robot's name, px. */
const DOT = 11;
/** Interval between two tests of a label for walls and robots, ms, and most labels tested in a frame. */
const LOOK_INTERVAL = 250;
const LOOKS = 8;

export class Labels {
  private readonly labels = new Map<string, Label>();
  private size = { width: 1, height: 1 };
  readonly layers: Record<LabelKind, boolean> = {
    pull: true,
    robot: true,
    start: true,
    node: true,
    object: true,
    goal: true,
    metres: true,
  };
  /** The label of a robot that is always shown first. */
  first: string | null = null;
  /** True if some have not yet been looked for behind walls and robots. */
  isBusy = false;

  constructor(
    private readonly parent: HTMLElement,
    private readonly isBehind: (place: THREE.Vector3, kind: LabelKind) => boolean,
  ) {
    parent.classList.add('view-labels');
  }

  /** Puts words at a place of the stage. */
  set(key: string, kind: LabelKind, text: string, place: THREE.Vector3, { colour, along }: Manner = {}): void {
    let label = this.labels.get(key);
    if (!label) {
      const element = document.createElement('span');
      element.className = `view-label ${kind}`;
      this.parent.append(element);
      label = {
        element,
        kind,
        place: new THREE.Vector3(),
        along: null,
        width: 0,
        hidden: false,
        looked: 0,
        behind: false,
        shown: -1,
      };
      this.labels.set(key, label);
    }
    label.place.copy(place);
    label.along = along ?? null;
    if (label.element.textContent !== text) {
      label.element.textContent = text;
      label.width = 0;
    }
    if (colour) label.element.style.setProperty('--own', colour);
  }

  remove(key: string): void {
    this.labels.get(key)?.element.remove();
    this.labels.delete(key);
  }

  /** Removes all of a kind that are not in a list. */
  keep(kind: LabelKind, keys: Set<string>): void {
    for (const [key, label] of this.labels) if (label.kind === kind && !keys.has(key)) this.remove(key);
  }

  clear(): void {
    [...this.labels.keys()].forEach((key) => this.remove(key));
  }

  resize(width: number, height: number): void {
    this.size = { width, height };
  }

  /** Draws all that have room. */
  update(camera: THREE.PerspectiveCamera, distance: number): void {
    const { width, height } = this.size;
    const seen: { label: Label; key: string; x: number; y: number; depth: number; strength: number }[] = [];
    const place = new THREE.Vector3();
    // From afar names are wanted, too, if all is far.
    const scale = Math.max(1, distance / 20);
    for (const [key, label] of this.labels) {
      place.copy(label.place).applyMatrix4(camera.matrixWorldInverse);
      const depth = -place.z;
      const [fades, ends] = RANGE[label.kind];
      const reach = label.kind === 'robot' || label.kind === 'metres' || label.kind === 'pull' ? scale : 1;
      const strength = 1 - Math.max(0, Math.min(1, (depth / reach - fades) / (ends - fades)));
      place.applyMatrix4(camera.projectionMatrix);
      const inside = Math.abs(place.x) < 1.05 && Math.abs(place.y) < 1.05;
      if (!this.layers[label.kind] || depth < camera.near || strength <= 0 || !inside) show(label, 0);
      else seen.push({ label, key, x: ((place.x + 1) / 2) * width, y: ((1 - place.y) / 2) * height, depth, strength });
    }
    const rank = ({ key, label, depth }: (typeof seen)[number]) =>
      key === this.first ? -1 : ORDER[label.kind] + depth;
    seen.sort((one, other) => rank(one) - rank(other));
    this.lookBehind(seen.map(({ label }) => label));
    const taken: [number, number, number, number][] = [];
    for (const { label, x, y, depth, strength } of seen) {
      if (label.behind) {
        show(label, 0);
        continue;
      }
      label.width ||= label.element.offsetWidth;
      const [left, bottom] = this.corner(label, x, y, depth, camera);
      const box: [number, number, number, number] = [
        left - 3,
        bottom - HEIGHT[label.kind] - 2,
        left + label.width + 3,
        bottom + 2,
      ];
      const covered = taken.some(
        (other) => box[0] < other[2] && box[2] > other[0] && box[1] < other[3] && box[3] > other[1],
      );
      show(label, covered ? 0 : strength);
      if (covered) continue;
      taken.push(box);
      label.element.style.transform = `translate(${left}px, ${bottom - HEIGHT[label.kind]}px)`;
    }
  }

  /** Draws those that are shown on a picture with so many pixels for one of the page. */
  drawOn(context: CanvasRenderingContext2D, ratio: number): void {
    const { x, y } = this.parent.getBoundingClientRect();
    context.save();
    context.scale(ratio, ratio);
    context.textBaseline = 'middle';
    for (const { element, shown, kind } of this.labels.values()) {
      if (shown <= 0) continue;
      const style = getComputedStyle(element);
      const box = element.getBoundingClientRect();
      const [left, top] = [box.x - x, box.y - y];
      context.globalAlpha = shown;
      context.fillStyle = style.backgroundColor;
      context.beginPath();
      context.roundRect(left, top, box.width, box.height, 4);
      context.fill();
      context.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
      context.fillStyle = style.color;
      const room = Number.parseFloat(style.paddingLeft) + (kind === 'robot' ? DOT : 0);
      context.fillText(element.textContent ?? '', left + room, top + box.height / 2 + 0.5);
      if (kind !== 'robot') continue;
      context.fillStyle = style.getPropertyValue('--own');
      context.beginPath();
      context.arc(left + room - DOT / 2 - 2, top + box.height / 2, 3.5, 0, 2 * Math.PI);
      context.fill();
    }
    context.restore();
  }

  /** The left bottom corner of a label, px. */
  private corner(label: Label, x: number, y: number, depth: number, camera: THREE.Camera): [number, number] {
    const [halfWidth, halfHeight] = [label.width / 2, HEIGHT[label.kind] / 2];
    if (!label.along) return [Math.round(x - halfWidth), Math.round(y) - (label.kind === 'robot' ? LEADER : 0)];
    const next = label.place
      .clone()
      .addScaledVector(label.along, 0.05 * depth)
      .project(camera);
    const [dx, dy] = [((next.x + 1) / 2) * this.size.width - x, ((1 - next.y) / 2) * this.size.height - y];
    const length = Math.hypot(dx, dy) || 1;
    // Across the line, to the right of it, or above where it lies level.
    const side = dy > 0.02 * length || (Math.abs(dy) <= 0.02 * length && dx < 0) ? 1 : -1;
    const [acrossX, acrossY] = [(side * dy) / length, (-side * dx) / length];
    const far = Math.abs(acrossX) * halfWidth + Math.abs(acrossY) * halfHeight + ASIDE;
    return [Math.round(x + acrossX * far - halfWidth), Math.round(y + acrossY * far + halfHeight)];
  }

  /** Some of them in each frame: rays through the map and the robots cost. */
  private lookBehind(labels: Label[]): void {
    const now = performance.now();
    const due = labels.filter(({ looked }) => now - looked > LOOK_INTERVAL);
    due.sort((one, other) => one.looked - other.looked);
    this.isBusy = due.length > LOOKS;
    for (const label of due.slice(0, LOOKS)) {
      label.looked = now;
      label.behind = this.isBehind(label.place, label.kind);
    }
  }
}

/** Only what changes costs. */
function show(label: Label, strength: number): void {
  const rounded = Math.round(strength * 20) / 20;
  if (rounded === label.shown) return;
  label.shown = rounded;
  label.element.style.opacity = String(rounded);
}
