/** The rungs of quality, and which of them the machine can afford by the time that frames take. */

import type { Shading } from './surfaces';

export interface Rung {
  /** Description for people. */
  what: string;
  /** Scale of the canvas, at a screen's own ratio. */
  pixelRatio: (screen: number) => number;
  shadows: boolean;
  /** Kind of materials. Standard ones reflect an environment. */
  shading: Shading;
  /** True for ambient occlusion, a pass of its own. */
  occlusion: boolean;
}

export const QUALITIES = [1, 2, 3, 4, 5] as const;
export type Quality = (typeof QUALITIES)[number];

const plain = { shadows: false, shading: 'plain', occlusion: false } as const;
const one = () => 1;
const fine = (screen: number) => Math.min(2, screen);

export const RUNGS: Record<Quality, Rung> = {
  1: { ...plain, what: 'few pixels', pixelRatio: () => 0.55 },
  2: { ...plain, what: 'most pixels', pixelRatio: () => 0.75 },
  3: { what: 'all pixels, shadows', pixelRatio: one, shadows: true, shading: 'matte', occlusion: false },
  4: { what: 'fine pixels, reflections', pixelRatio: fine, shadows: true, shading: 'standard', occlusion: false },
  5: { what: 'dark corners, too', pixelRatio: fine, shadows: true, shading: 'standard', occlusion: true },
};

/** Frame time above which the ladder is descended, and below which it is climbed from a rung, ms. */
const LIMITS = {
  // The second rung costs little more than the first, the third is another world.
  software: { most: 48, least: (rung: Quality) => (rung === 1 ? 32 : 17) },
  hardware: { most: 21, least: () => 8 },
};
/** Frames that are judged together. */
const JUDGED = 12;
/** Frames after a change that are not judged: shaders are being made. */
const SETTLING = 10;
/** A rung that was too dear is not tried again for so long, ms; each time it fails, twice as long. */
const PATIENCE = 20_000;

export class Ladder {
  rung: Quality;
  /** True while somebody holds the rung. */
  isFixed = false;
  private times: number[] = [];
  private settling = SETTLING;
  private readonly tooDear = new Map<Quality, { until: number; wait: number }>();

  constructor(
    private readonly software: boolean,
    private readonly changed: (rung: Quality) => void,
  ) {
    this.rung = software ? 2 : 4;
  }

  set(quality: Quality | 'auto'): void {
    this.isFixed = quality !== 'auto';
    if (quality !== 'auto') this.go(quality);
  }

  /** A frame took so long, ms. */
  took(time: number): void {
    if (this.isFixed || this.settling-- > 0) return;
    this.times.push(time);
    if (this.times.length < JUDGED) return;
    const middle = this.times.sort((a, b) => a - b)[JUDGED >> 1] ?? 0;
    this.times = [];
    const { most, least } = this.software ? LIMITS.software : LIMITS.hardware;
    if (middle > most && this.rung > 1) {
      const wait = 2 * (this.tooDear.get(this.rung)?.wait ?? PATIENCE / 2);
      this.tooDear.set(this.rung, { until: performance.now() + wait, wait });
      this.go((this.rung - 1) as Quality);
    } else if (middle < least(this.rung) && this.rung < 5) {
      const next = (this.rung + 1) as Quality;
      if (performance.now() > (this.tooDear.get(next)?.until ?? 0)) this.go(next);
    }
  }

  private go(rung: Quality): void {
    this.times = [];
    this.settling = SETTLING;
    if (rung === this.rung) return;
    this.rung = rung;
    this.changed(rung);
  }
}

/** True if the browser draws without a graphics card. */
export function isSoftware(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  const info = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = gl && info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}
