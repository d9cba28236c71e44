/** A link to what is shown: the map, its robots, the camera, and a moment of a log. It stands behind the page's address. */

import type { Vector } from './protocol/scene';

/** Place from which the camera looks, and place that it looks at, m. */
export interface Viewpoint {
  from: Vector;
  at: Vector;
}

export interface LinkedRobot {
  robotClass: string;
  location: Vector;
  /** rad */
  yaw: number;
}

export interface Link {
  map: string | null;
  robots: LinkedRobot[];
  camera: Viewpoint | null;
  /** Name of a log, and the moment that is shown of it, s. */
  log: { name: string; time: number } | null;
}

/** Most robots that a link brings. */
const MOST_ROBOTS = 20;

/** Returns the text behind `#`. */
export function writeLink({ map, robots, camera, log }: Link): string {
  const parts = [
    ...(map ? [`map=${encodeURIComponent(map)}`] : []),
    ...(robots.length > 0 ? [`robots=${robots.slice(0, MOST_ROBOTS).map(robotText).join(';')}`] : []),
    ...(camera ? [`camera=${numbers([...camera.from, ...camera.at])}`] : []),
    ...(log ? [`log=${encodeURIComponent(log.name)}`, `t=${log.time.toFixed(2)}`] : []),
  ];
  return parts.join('&');
}

/** Reads a link; null if it has nothing to show. What is not understood is left out. */
export function readLink(hash: string): Link | null {
  const parts = new URLSearchParams(hash.replace(/^#/, ''));
  const camera = readNumbers(parts.get('camera'), 6);
  const robots = (parts.get('robots') ?? '').split(';').flatMap((text) => readRobot(text) ?? []);
  const name = parts.get('log');
  const [time = 0] = readNumbers(parts.get('t'), 1) ?? [];
  const link: Link = {
    map: parts.get('map'),
    robots: robots.slice(0, MOST_ROBOTS),
    camera: camera && { from: camera.slice(0, 3) as Vector, at: camera.slice(3) as Vector },
    log: name === null ? null : { name, time },
  };
  return link.map !== null || link.camera || link.log || link.robots.length > 0 ? link : null;
}

function robotText({ robotClass, location, yaw }: LinkedRobot): string {
  return `${encodeURIComponent(robotClass)}@${numbers([...location, yaw])}`;
}

function readRobot(text: string): LinkedRobot | null {
  const [robotClass = '', place = ''] = text.split('@');
  const [x, y, z, yaw] = readNumbers(place, 4) ?? [];
  if (!/^\w+$/.test(robotClass) || x === undefined || y === undefined || z === undefined) return null;
  return { robotClass, location: [x, y, z], yaw: yaw ?? 0 };
}

function numbers(list: number[]): string {
  return list.map((number) => Number(number.toFixed(3))).join(',');
}

/** Reads so many finite numbers; null if they are others. */
function readNumbers(text: string | null, count: number): number[] | null {
  const list = (text ?? '').split(',').map((part) => (part.trim() === '' ? Number.NaN : Number(part)));
  return list.length === count && list.every((number) => Math.abs(number) < 1e5) ? list : null;
}
