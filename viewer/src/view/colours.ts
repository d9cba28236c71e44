/** The robots' own colours and those of the world's light. */

import * as THREE from 'three';
import type { Colour, RobotClass, Shape } from '../protocol/scene';
import { ownBounds } from './solid';

/**
 * After Okabe and Ito, so that the colour-blind can tell them apart; made to be seen on light and on dark. Red is kept
 * for errors.
 */
export const COLOURS = [
  '#1f83d6',
  '#e69f00',
  '#00a37a',
  '#cc79a7',
  '#4cc3ee',
  '#8b6ad8',
  '#d9c622',
  '#a0693a',
  '#7f9a2e',
  '#8a8f98',
] as const;

/** Difference of the strongest and the weakest part from which a colour counts as one. */
const VIVID = 0.12;
/** Difference of two colours below which a ring around a robot is lost beside it: distance in Oklab. */
const LIKE = 0.16;

/**
 * Returns the colour of a robot. It goes by the robot's name: every page shows the same, also after the robot is spawned again. The
 * number at the end of a name is counted, so that Robot1 to Robot10 differ. A colour that is like that of the robot's body is not taken.
 */
export function colourOf({ id, name }: { id: number; name: string }, body: Colour | null = null): string {
  const [, stem = '', number = ''] = /^(.*?)(\d{0,9})$/s.exec(name || String(id)) ?? [];
  const free = COLOURS.filter((colour) => !body || difference(linear(colour), body) > LIKE);
  // The page's first robot, Robot1, has the first colour.
  let hash = 2;
  for (const letter of stem) hash = (31 * hash + (letter.codePointAt(0) ?? 0)) % 65_521;
  return colourAt(hash + Number(number), free);
}

const bodies = new WeakMap<RobotClass, Colour | null>();

/** Returns the colour that a robot's body has most of, in linear light; null if it is black, grey or white. */
export function bodyColour(robotClass: RobotClass): Colour | null {
  const known = bodies.get(robotClass);
  if (known !== undefined) return known;
  const areas = new Map<string, { colour: Colour; area: number }>();
  for (const { shape, colour } of [...robotClass.drawn, ...robotClass.links.flatMap(({ drawn }) => drawn)]) {
    if (Math.max(...colour) - Math.min(...colour) < VIVID) continue;
    const entry = areas.get(String(colour)) ?? { colour, area: 0 };
    entry.area += areaOf(shape);
    areas.set(String(colour), entry);
  }
  const [most] = [...areas.values()].sort((one, other) => other.area - one.area);
  const found = most?.colour ?? null;
  bodies.set(robotClass, found);
  return found;
}

/** Returns the area of the box around a shape, m². */
function areaOf(shape: Shape): number {
  if (shape === 'HalfSpace') return 0;
  const { x, y, z } = ownBounds(shape).getSize(new THREE.Vector3());
  return x * y + y * z + z * x;
}

function linear(colour: string): Colour {
  const { r, g, b } = new THREE.Color(colour);
  return [r, g, b];
}

/** Returns the distance of two colours as people see them (Oklab, B. Ottosson 2020). */
function difference(one: Colour, other: Colour): number {
  const [first, second] = [one, other].map(oklab);
  return Math.hypot(...(first ?? []).map((part, index) => part - (second?.[index] ?? 0)));
}

function oklab([r, g, b]: Colour): Colour {
  const cone = (red: number, green: number, blue: number) => Math.cbrt(red * r + green * g + blue * b);
  const l = cone(0.4122214708, 0.5363325363, 0.0514459929);
  const m = cone(0.2119034982, 0.6806995451, 0.1073969566);
  const s = cone(0.0883024619, 0.2817188376, 0.6299787005);
  return [
    0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
    1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
  ];
}

/** Returns the colour at a place of the list, which begins again after its end. */
function colourAt(index: number, colours: readonly string[] = COLOURS): string {
  return colours[index % colours.length] ?? '#8a8f98';
}

/** Colours of teams that are called after one. */
const NAMED: Record<string, string> = {
  red: '#d64550',
  blue: '#1f83d6',
  green: '#00a37a',
  yellow: '#d9c622',
  orange: '#e69f00',
  purple: '#8b6ad8',
  pink: '#cc79a7',
  brown: '#a0693a',
};

/** Returns the colour of a team by its name, or else by its place in the league. */
export function teamColour(name: string, index: number): string {
  return NAMED[name.toLowerCase()] ?? colourAt(index);
}

/** Returns the colours of a chart's curves: a thing's first curve has the colour of the thing, every other one a free colour. */
export function curveColours(curves: { thing: string; colour: string }[]): string[] {
  const isFirst = curves.map(({ thing }, index) => curves.findIndex((curve) => curve.thing === thing) === index);
  const taken = new Set(curves.filter((_, index) => isFirst[index]).map(({ colour }) => colour));
  const free = COLOURS.filter((colour) => !taken.has(colour));
  let next = 0;
  return curves.map(({ colour }, index) => {
    if (isFirst[index]) return colour;
    return (free.length > 0 ? free[next++ % free.length] : undefined) ?? colourAt(index);
  });
}

/** Colours of contact forces, which no robot and no axis has: of a contact with all of its friction left, and of one that slides. */
export const FORCE_COLOURS = ['#ff10c0', '#6a00ff'] as const;

/** Colours of the axes x, y and z. */
export const AXIS_COLOURS = ['#e0525e', '#3fa66a', '#4a7fe0'] as const;

/** Light and air of the world, in the page's dark theme, too: panels have themes. */
export const LIGHT = {
  /** Colours of the sky at the horizon, and straight above. */
  horizon: '#e6ebf0',
  zenith: '#b3c6da',
  /** Ambient light: from above, and back from the ground. */
  fromSky: '#eef4ff',
  fromGround: '#b9b3a8',
  ambient: 1.75,
  key: '#fff4e2',
  keyStrength: 1.9,
  /** Strength of the environment that shiny things reflect. */
  reflection: 0.55,
} as const;
