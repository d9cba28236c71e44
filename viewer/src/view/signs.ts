/** Texts of the labels: names of robots, starts, nodes, goals and objects, and metres along the axes. */

import * as THREE from 'three';
import { startsOf } from '../offer';
import type { ObjectState } from '../protocol/frame';
import type { Scene } from '../protocol/scene';
import type { Labels } from './labels';
import type { Catalogue } from './map';
import { onStage } from './pose';
import type { Robots } from './robots';

/** Metres between two labels on an axis that can be chosen, and the least that is between them on the screen, px. */
const STEPS = [0.5, 1, 2, 5, 10, 20, 50, 100];
const LEAST_GAP = 110;
/** Axes on the stage. */
const X_AXIS = new THREE.Vector3(1, 0, 0);
const Y_AXIS = new THREE.Vector3(0, -1, 0);

/** A robot that is so near to a start stands on its label, m. */
const NEAR = 0.15;

export function labelMap(labels: Labels, scene: Scene): void {
  for (const { label, position } of startsOf(scene)) labels.set(`start ${label}`, 'start', label, onStage(position));
  for (const { name, position } of scene.map.path_nodes) labels.set(`node ${name}`, 'node', name, onStage(position));
  for (const { name, position } of scene.league?.targets ?? []) {
    labels.set(`goal ${name}`, 'goal', name.replaceAll('-', ' '), onStage(position));
  }
}

/** Starts on which no robot stands. */
export function labelStarts(labels: Labels, scene: Scene, robots: Robots): void {
  const free = startsOf(scene).filter(({ position: [x, y] }) =>
    robots.all.every(({ state: { pose }, fleet }) => Math.hypot(pose[0] - x, pose[1] - y) > fleet.size / 2 + NEAR),
  );
  for (const { label, position } of free) labels.set(`start ${label}`, 'start', label, onStage(position));
  labels.keep('start', new Set(free.map(({ label }) => `start ${label}`)));
}

/** Labels the objects that are known. */
export function labelObjects(labels: Labels, objects: ObjectState[], catalogue: Catalogue): void {
  const keys = new Set<string>();
  for (const { number, pose } of objects) {
    const name = catalogue(number)?.name;
    if (name === undefined) continue;
    const key = `object ${number}`;
    keys.add(key);
    labels.set(key, 'object', name, onStage([pose[0], pose[1], pose[2]]));
  }
  labels.keep('object', keys);
}

export function labelRobots(labels: Labels, robots: Robots): void {
  const keys = new Set<string>();
  for (const { state, name, colour, fleet } of robots.all) {
    const [x, y, z] = state.pose;
    const key = `robot ${state.id}`;
    keys.add(key);
    labels.set(key, 'robot', name, onStage([x, y, z - fleet.height(state)]), { colour });
  }
  labels.keep('robot', keys);
  labels.first = robots.selected === null ? null : `robot ${robots.selected}`;
}

/** Metres along the two sides of a box of the stage that are nearer to the eye, as on a chart's edges. */
export function labelMetres(
  labels: Labels,
  { min, max }: THREE.Box3,
  eye: THREE.Vector3,
  metresPer100Pixels: number,
): void {
  const gap = (LEAST_GAP / 100) * metresPer100Pixels;
  const step = STEPS.find((length) => length >= gap) ?? 200;
  const [right, left] = [eye.x > (min.x + max.x) / 2 ? max.x : min.x, eye.y > (min.y + max.y) / 2 ? max.y : min.y];
  const keys = new Set<string>();
  const add = (axis: 'x' | 'y', at: number, place: THREE.Vector3) => {
    const key = `metres ${axis} ${at}`;
    keys.add(key);
    labels.set(key, 'metres', `${axis} ${at}`, place, { along: axis === 'x' ? X_AXIS : Y_AXIS });
  };
  for (const at of multiples(step, min.x, max.x)) add('x', at, new THREE.Vector3(at, left, 0));
  for (const at of multiples(step, -max.y, -min.y)) add('y', at, new THREE.Vector3(right, -at, 0));
  labels.keep('metres', keys);
}

/** Multiples of a step between two numbers. */
function multiples(step: number, least: number, most: number): number[] {
  const first = Math.ceil(least / step);
  return Array.from({ length: Math.max(0, Math.floor(most / step) - first + 1) }, (_, index) => (first + index) * step);
}
