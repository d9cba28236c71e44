/** The wire's axes in a corner, x ahead, y to the right, z down; a press on an end looks along it. */

import * as THREE from 'three';
import { AXIS_COLOURS } from './colours';

const SPACE = 'http://www.w3.org/2000/svg';
const NAMES = ['x', 'y', 'z'] as const;
/** Middle and length of the axes in the drawing, px. */
const MIDDLE = 42;
const LENGTH = 28;

interface End {
  /** Direction on the stage, where y and z are turned over. */
  direction: THREE.Vector3;
  ball: SVGElement;
  line: SVGElement | null;
}

export class Gizmo {
  private readonly drawing = make('svg', { class: 'view-gizmo', viewBox: '0 0 84 84', role: 'group' });
  private readonly ends: End[] = [];
  private readonly last = new THREE.Quaternion(0, 0, 0, 0);

  /** `look` is told from where: yaw and pitch of the camera, rad. */
  constructor(parent: HTMLElement, look: (yaw: number | null, pitch: number) => void) {
    this.drawing.setAttribute('aria-label', 'Directions to look from');
    for (const sign of [-1, 1]) {
      NAMES.forEach((name, axis) => {
        // The wire's y and z are turned over on the stage.
        const direction = new THREE.Vector3().setComponent(axis, axis === 0 ? sign : -sign);
        const ball = make('g', { class: 'ball' });
        const title = make('title', {});
        title.textContent = `Look from ${sign > 0 ? '+' : '-'}${name}`;
        ball.append(
          title,
          make('circle', {
            r: sign > 0 ? '8.5' : '6',
            fill: AXIS_COLOURS[axis] ?? '',
            'fill-opacity': sign > 0 ? '1' : '0.4',
          }),
        );
        if (sign > 0) ball.append(text(name));
        ball.addEventListener('click', () => {
          if (axis === 2) look(null, direction.z > 0 ? Math.PI / 2 : 0.02);
          else look(Math.atan2(-direction.y, -direction.x), 0.02);
        });
        const line =
          sign > 0
            ? make('line', { stroke: AXIS_COLOURS[axis] ?? '', 'stroke-width': '2.5', 'stroke-linecap': 'round' })
            : null;
        this.ends.push({ direction, ball, line });
      });
    }
    parent.append(this.drawing);
  }

  update(camera: THREE.Camera): void {
    if (Math.abs(this.last.dot(camera.quaternion)) > 1 - 1e-7) return;
    this.last.copy(camera.quaternion);
    const turned = this.ends.map((end) => ({
      ...end,
      seen: end.direction.clone().applyQuaternion(camera.quaternion.clone().invert()),
    }));
    // What is nearer covers what is behind it.
    turned.sort((one, other) => one.seen.z - other.seen.z);
    for (const { seen, ball, line } of turned) {
      const [x, y] = [MIDDLE + LENGTH * seen.x, MIDDLE - LENGTH * seen.y];
      ball.setAttribute('transform', `translate(${x.toFixed(1)} ${y.toFixed(1)})`);
      for (const [name, value] of [
        ['x1', MIDDLE],
        ['y1', MIDDLE],
        ['x2', x],
        ['y2', y],
      ] as const) {
        line?.setAttribute(name, value.toFixed(1));
      }
      if (line) this.drawing.append(line);
      this.drawing.append(ball);
    }
  }
}

function make(name: string, attributes: Record<string, string>): SVGElement {
  const element = document.createElementNS(SPACE, name);
  Object.entries(attributes).forEach(([key, value]) => element.setAttribute(key, value));
  return element;
}

function text(content: string): SVGElement {
  const element = make('text', {});
  element.textContent = content;
  return element;
}
