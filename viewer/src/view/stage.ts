/** The renderer with its light, sky and grid, at one of the rungs of quality. */

import * as THREE from 'three';
import { DARK, LIGHT, type Theme } from './colours';
import { makeEnvironment } from './environment';
import { Grid } from './grid';
import { Lights } from './lights';
import { OcclusionRenderer } from './occlusion';
import { pathUniforms } from './paths';
import { Ladder, type Quality, RUNGS, type Rung, isSoftware } from './quality';
import { Sky } from './sky';
import { Stopwatch } from './stopwatch';
import { Surfaces } from './surfaces';
import { setToneMapping } from './tone';

/** Width of a path, px, at low rungs and at high ones, and least width in drawn pixels, so that it has no gaps. */
const PATH_BREADTHS = [1.4, 2.6] as const;
const LEAST_BREADTH = 1.2;

/** Settings of a picture that is saved, however long it takes. */
const SAVED: Rung = { ...RUNGS[5], pixelRatio: (screen) => screen };

export class Stage {
  readonly renderer: THREE.WebGLRenderer;
  readonly scene = new THREE.Scene();
  /** World with z down, as on the wire. */
  readonly world = new THREE.Group();
  readonly surfaces: Surfaces;
  readonly grid = new Grid();
  readonly isSoftware = isSoftware();
  readonly ladder: Ladder;
  readonly stopwatch: Stopwatch;
  theme: Theme = LIGHT;
  private readonly lights = new Lights();
  private readonly sky = new Sky();
  private readonly fog = new THREE.Fog(0xffffff, 30, 120);
  private environment: THREE.Texture | null = null;
  private occlusion: OcclusionRenderer | null = null;
  private size = { width: 1, height: 1 };
  private isSaving = false;

  constructor(
    canvas: HTMLCanvasElement,
    private readonly camera: THREE.Camera,
    private readonly bodiless: () => THREE.Object3D[],
    private readonly changed: () => void,
  ) {
    // Without a graphics card smooth edges would take most of the time.
    const wanted = { antialias: !this.isSoftware, stencil: true };
    // By itself three.js takes a picture that what is behind it shines through, which the browser has to blend each time.
    const context = canvas.getContext('webgl2', { ...wanted, alpha: false, powerPreference: 'high-performance' });
    this.renderer = new THREE.WebGLRenderer({ canvas, ...(context && { context }), ...wanted });
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    setToneMapping(this.renderer);
    this.surfaces = new Surfaces(this.isSoftware ? 1 : Math.min(8, this.renderer.capabilities.getMaxAnisotropy()));
    this.world.rotation.x = Math.PI;
    this.scene.fog = this.fog;
    this.scene.add(this.world, this.lights.group, this.sky.mesh, this.grid.mesh);
    this.ladder = new Ladder(this.isSoftware, () => this.applyQuality());
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    this.stopwatch = new Stopwatch(gl, (time) => this.ladder.took(time));
    this.setDark(false);
    this.applyQuality();
  }

  get quality(): Quality {
    return this.ladder.rung;
  }

  private get rung(): Rung {
    return this.isSaving ? SAVED : RUNGS[this.quality];
  }

  /** Draws with all pixels of the screen and at the best quality until it is told otherwise. */
  setSaving(isSaving: boolean): void {
    this.isSaving = isSaving;
    this.applyQuality();
  }

  setDark(dark: boolean): void {
    this.theme = dark ? DARK : LIGHT;
    this.lights.setTheme(this.theme);
    this.sky.setTheme(this.theme);
    this.grid.setTheme(this.theme);
    this.fog.color.set(this.theme.horizon);
    // Until there is a world to draw.
    this.renderer.setClearColor(this.theme.horizon);
    this.renderer.clear();
    this.applyQuality();
  }

  resize(width: number, height: number): void {
    this.size = { width, height };
    const ratio = this.rung.pixelRatio(window.devicePixelRatio);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.occlusion?.resize(width, height, ratio);
    pathUniforms.screen.value.set(width, height);
    const breadth = PATH_BREADTHS[this.rung.shading === 'standard' ? 1 : 0];
    pathUniforms.breadth.value = Math.max(breadth, LEAST_BREADTH / ratio);
  }

  /** The shadows are drawn anew with the next picture. */
  renewShadows(): void {
    this.renderer.shadowMap.needsUpdate = true;
  }

  /** Draws what is around a place that is so far from the camera. */
  render(target: THREE.Vector3, distance: number): void {
    const began = performance.now();
    this.grid.follow(target, distance);
    this.fog.near = 12 + 2 * distance;
    this.fog.far = 90 + 7 * distance;
    if (this.lights.cover(target, 0.75 * distance)) this.renewShadows();
    if (this.rung.occlusion) this.occluding().render();
    else this.renderer.render(this.scene, this.camera);
    if (!this.isSaving) this.stopwatch.drawn(began);
  }

  private occluding(): OcclusionRenderer {
    if (!this.occlusion) {
      const bodiless = () => [this.sky.mesh, this.grid.mesh, ...this.bodiless()];
      this.occlusion = new OcclusionRenderer(this.renderer, this.scene, this.camera, bodiless);
      this.resize(this.size.width, this.size.height);
    }
    return this.occlusion;
  }

  private applyQuality(): void {
    const { shadows, shading } = this.rung;
    const standard = shading === 'standard';
    this.renderer.shadowMap.enabled = shadows;
    this.lights.castShadows(shadows);
    this.surfaces.setShading(shading);
    this.surfaces.refresh(this.world);
    if (standard) this.environment ??= makeEnvironment(this.renderer);
    this.scene.environment = standard ? this.environment : null;
    this.scene.environmentIntensity = this.theme.reflection;
    this.lights.setEnvironment(standard);
    this.resize(this.size.width, this.size.height);
    this.renewShadows();
    this.changed();
  }
}
