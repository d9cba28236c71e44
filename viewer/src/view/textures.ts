/** Small pictures that repeat, made by code: how light or dark a surface is from place to place. */

import * as THREE from 'three';

export interface Pattern {
  /** Edge of the area that the picture covers, m. */
  tile: number;
  /** 0 to 1 at a place of the picture, u and v 0 to 1, u along the grain */
  shade: (u: number, v: number) => number;
}

const EDGE = 256;

/** A number of 0 to 1 that belongs to a point of a lattice. */
function random(x: number, y: number, seed: number): number {
  let bits = Math.imul(x, 374761393) ^ Math.imul(y, 668265263) ^ Math.imul(seed, 2147483647);
  bits = Math.imul(bits ^ (bits >>> 13), 1274126177);
  return ((bits ^ (bits >>> 16)) >>> 0) / 4294967295;
}

/** Smooth noise of 0 to 1 that repeats after so many cells along u and v. */
function noise(u: number, v: number, cellsU: number, cellsV: number, seed: number): number {
  const [x, y] = [u * cellsU, v * cellsV];
  const [left, top] = [Math.floor(x), Math.floor(y)];
  const smooth = (part: number) => part * part * (3 - 2 * part);
  const [right, down] = [smooth(x - left), smooth(y - top)];
  const at = (i: number, j: number) => random((left + i) % cellsU, (top + j) % cellsV, seed);
  const upper = at(0, 0) + (at(1, 0) - at(0, 0)) * right;
  const lower = at(0, 1) + (at(1, 1) - at(0, 1)) * right;
  return upper + (lower - upper) * down;
}

/** Blotches, cloudy, and grains between them. */
const cloudy = (u: number, v: number) =>
  0.45 * noise(u, v, 5, 5, 1) + 0.3 * noise(u, v, 13, 13, 2) + 0.25 * noise(u, v, 37, 37, 3);
const grains = (u: number, v: number, seed: number) => noise(u, v, 256, 256, seed);

export const PATTERNS = {
  concrete: {
    tile: 3,
    shade: (u, v) => {
      const pore = grains(u, v, 5) > 0.985 ? 0.16 : 0;
      return 0.86 + 0.1 * (cloudy(u, v) - 0.5) + 0.07 * (grains(u, v, 4) - 0.5) - pore;
    },
  },
  wood: {
    tile: 1.6,
    shade: (u, v) => {
      const bend = v + 0.03 * noise(u, v, 3, 4, 7);
      const rings = 0.5 + 0.5 * Math.sin(2 * Math.PI * (9 * bend + 1.5 * noise(u, v, 2, 6, 8)));
      const fibres = noise(u, v, 10, 128, 9);
      return 0.86 + 0.09 * (rings - 0.5) + 0.12 * (fibres - 0.5);
    },
  },
  carpet: {
    tile: 0.8,
    shade: (u, v) => 0.8 + 0.26 * (grains(u, v, 11) - 0.5) + 0.14 * (noise(u, v, 128, 64, 12) - 0.5),
  },
  metal: {
    tile: 0.5,
    shade: (u, v) => 0.9 + 0.1 * (noise(u, v, 4, 256, 13) - 0.5) + 0.04 * (noise(u, v, 3, 3, 14) - 0.5),
  },
  sand: {
    tile: 1.2,
    shade: (u, v) => 0.84 + 0.12 * (cloudy(u, v) - 0.5) + 0.2 * (grains(u, v, 15) - 0.5),
  },
  ice: {
    tile: 2.5,
    shade: (u, v) => 0.93 + 0.08 * (cloudy(u, v) - 0.5) - (Math.abs(noise(u, v, 4, 4, 16) - 0.5) < 0.008 ? 0.08 : 0),
  },
  rubber: { tile: 0.3, shade: (u, v) => 0.9 + 0.12 * (grains(u, v, 17) - 0.5) },
} satisfies Record<string, Pattern>;

export type PatternName = keyof typeof PATTERNS;

/** The picture, and how light it is in the mean. */
export function patternTexture(name: PatternName): { texture: THREE.DataTexture; mean: number } {
  const { shade } = PATTERNS[name];
  const texels = new Uint8Array(4 * EDGE * EDGE);
  let sum = 0;
  for (let row = 0; row < EDGE; row++) {
    for (let column = 0; column < EDGE; column++) {
      const value = Math.min(1, Math.max(0, shade(column / EDGE, row / EDGE)));
      sum += value;
      texels.fill(255 * value, 4 * (row * EDGE + column), 4 * (row * EDGE + column) + 3);
      texels[4 * (row * EDGE + column) + 3] = 255;
    }
  }
  const texture = new THREE.DataTexture(texels, EDGE, EDGE);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.magFilter = THREE.LinearFilter;
  texture.minFilter = THREE.LinearMipmapNearestFilter;
  texture.generateMipmaps = true;
  texture.needsUpdate = true;
  return { texture, mean: sum / (EDGE * EDGE) };
}
