/** The renderer with its light, sky and grid, at one of the rungs of quality. */

import * as THREE from 'three';
import { LIGHT } from './colours';
import { DEPTH_COLOURS, depthMaterial, depthRange } from './depth';
import { makeEnvironment } from './environment';
import { Grid } from './grid';
import { Lights } from './lights';
import { OcclusionRenderer } from './occlusion';
import { pathUniforms } from './paths';
import { Ladder, type Quality, RUNGS, type Rung, isSoftware } from './quality';
import { Rim } from './rim';
import { Shade } from './shade';
import { Sky } from './sky';
import { Stopwatch } from './stopwatch';
import { Surfaces } from './surfaces';
import { setToneMapping } from './tone';

/** Width of a path, px, at low rungs and at high ones, and least width in drawn pixels, so that it has no gaps. */
const PATH_BREADTHS = [1.4, 2.6] as const;
const LEAST_BREADTH = 1.2;

/** Settings of a picture that is saved, however long it takes. */
const SAVED: Rung = { ...RUNGS[5], pixelRatio: (screen) => screen };
/** Settings of a still picture without a graphics card, where what shiny things reflect takes seconds to make, and holds up the view. */
const STILL_OF_SOFTWARE: Rung = { ...SAVED, shading: 'matte' };

/** Rows beside a strip that are drawn with it: corners are dark by what is around them. */
const MARGIN = 24;

export class Stage {
  readonly renderer: THREE.WebGLRenderer;
  readonly scene = new THREE.Scene();
  /** World with z down, as on the wire. */
  readonly world = new THREE.Group();
  readonly surfaces: Surfaces;
  readonly grid = new Grid();
  readonly rim = new Rim();
  private readonly shade = new Shade();
  readonly isSoftware = isSoftware();
  readonly ladder: Ladder;
  readonly stopwatch: Stopwatch;
  private readonly lights = new Lights();
  private readonly sky = new Sky();
  private readonly fog = new THREE.Fog(0xffffff, 30, 120);
  private environment: THREE.Texture | null = null;
  private occlusion: OcclusionRenderer | null = null;
  /** Draws strips of still pictures, and takes them. */
  private aside: { renderer: OcclusionRenderer; target: THREE.WebGLRenderTarget } | null = null;
  private size = { width: 1, height: 1 };
  /** Draws depths in place of what things look like; null for that. */
  private depth: THREE.ShaderMaterial | null = null;
  /** True if the map has a floor, and if that is drawn. */
  private hasFloor = false;
  private isFloorShown = true;
  /** Settings of a picture that is drawn whatever the ladder says. */
  private held: Rung | null = null;
  /** Meshes around the world without a body. */
  private readonly around = [this.sky, this.rim, this.grid, this.shade].map(({ mesh }) => mesh);

  constructor(
    canvas: HTMLCanvasElement,
    private readonly camera: THREE.PerspectiveCamera,
    private readonly bodiless: () => THREE.Object3D[],
    /** Tells the size of what is drawn on, px, and its pixels over those of the page. */
    private readonly resized: (width: number, height: number, ratio: number) => void,
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
    this.scene.add(this.world, this.lights.group, ...this.around);
    this.ladder = new Ladder(this.isSoftware, () => this.applyQuality());
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    this.stopwatch = new Stopwatch(gl, (time) => this.ladder.took(time));
    this.fog.color.set(LIGHT.horizon);
    // Until there is a world to draw.
    this.renderer.setClearColor(LIGHT.horizon);
    this.renderer.clear();
    this.applyQuality();
  }

  get quality(): Quality {
    return this.ladder.rung;
  }

  /** Pixels that are drawn for one of the page. */
  get sharpness(): number {
    return this.renderer.getPixelRatio();
  }

  private get rung(): Rung {
    return this.held ?? RUNGS[this.quality];
  }

  /** Draws with all pixels of the screen and at the best quality until it is told otherwise. */
  setSaving(isSaving: boolean): void {
    this.held = isSaving ? SAVED : null;
    this.applyQuality();
  }

  resize(width: number, height: number): void {
    this.size = { width, height };
    const ratio = this.rung.pixelRatio(window.devicePixelRatio);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.occlusion?.resize(width, height, ratio);
    this.setScreen(width, height, ratio);
  }

  /** Takes what never moves, with a box around its finite parts. Without a floor nothing fades, and no shadow falls on it. */
  setGround(ground: THREE.Object3D, box: THREE.Box3, hasFloor: boolean): void {
    this.hasFloor = hasFloor;
    if (hasFloor) this.shade.draw(this.renderer, ground, box);
    this.dress();
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
    if (this.depth) this.renderDepths(this.depth, distance);
    else if (this.rung.occlusion) this.occluding().render();
    else this.renderer.render(this.scene, this.camera);
    if (!this.held) this.stopwatch.drawn(began);
  }

  /** Draws depths as colours, or what things look like. */
  showDepths(shown: boolean): void {
    this.depth?.dispose();
    this.depth = shown ? depthMaterial() : null;
  }

  /** Puts a colour behind the world in place of sky and fog; null for these. */
  setBackdrop(colour: THREE.ColorRepresentation | null): void {
    this.sky.mesh.visible = colour === null;
    this.scene.fog = colour === null ? this.fog : null;
    this.scene.background = colour === null ? null : new THREE.Color(colour);
  }

  /** Shows the rim of the floor and the shadow on it, or neither. */
  showFloor(shown: boolean): void {
    this.isFloorShown = shown;
    this.dress();
  }

  /** Draws what has a body by its distance. */
  private renderDepths(material: THREE.ShaderMaterial, distance: number): void {
    (material.uniforms.range?.value as THREE.Vector2).set(...depthRange(distance));
    const hidden = [...this.around, ...this.bodiless()].filter(({ visible }) => visible);
    hidden.forEach((object) => (object.visible = false));
    const { background } = this.scene;
    Object.assign(this.scene, { overrideMaterial: material, background: new THREE.Color(DEPTH_COLOURS.at(-1)) });
    this.renderer.render(this.scene, this.camera);
    Object.assign(this.scene, { overrideMaterial: null, background });
    hidden.forEach((object) => (object.visible = true));
  }

  /** True if a still picture would be better than what is drawn now, and nobody holds a rung. */
  get canImprove(): boolean {
    return this.quality < 5 && !this.ladder.isFixed && this.depth === null;
  }

  /**
   * Draws some rows of a picture of the last view at the best quality, aside. Returns their pixels, from the lowest row up. The picture on the
   * canvas stays.
   */
  async rows(
    first: number,
    { width, height, rows, ratio }: { width: number; height: number; rows: number; ratio: number },
  ): Promise<Uint8Array> {
    const drawn = rows + 2 * MARGIN;
    this.aside ??= {
      renderer: this.occlusionRenderer(),
      target: new THREE.WebGLRenderTarget(1, 1, { depthBuffer: false }),
    };
    const { renderer, target } = this.aside;
    this.held = this.isSoftware ? STILL_OF_SOFTWARE : SAVED;
    this.dress();
    // The first strip's are those of the others.
    if (first === 0) this.renewShadows();
    target.setSize(width, drawn);
    renderer.resize(width, drawn, 1);
    this.setScreen(width / ratio, drawn / ratio, ratio);
    this.camera.setViewOffset(width, height, 0, first - MARGIN, width, drawn);
    renderer.render(target);
    this.camera.clearViewOffset();
    this.held = null;
    this.dress();
    this.setScreen(this.size.width, this.size.height, this.renderer.getPixelRatio());
    const kept = Math.min(rows, height - first);
    const pixels = new Uint8Array(4 * width * kept);
    await this.renderer.readRenderTargetPixelsAsync(target, 0, drawn - MARGIN - kept, width, kept, pixels);
    return pixels;
  }

  private occluding(): OcclusionRenderer {
    if (!this.occlusion) {
      this.occlusion = this.occlusionRenderer();
      this.resize(this.size.width, this.size.height);
    }
    return this.occlusion;
  }

  private occlusionRenderer(): OcclusionRenderer {
    const bodiless = () => [...this.around, ...this.bodiless()];
    return new OcclusionRenderer(this.renderer, this.scene, this.camera, bodiless);
  }

  /** Sets the size of what is drawn on, px, for lines of some pixels. */
  private setScreen(width: number, height: number, ratio: number): void {
    const breadth = PATH_BREADTHS[this.rung.shading === 'standard' ? 1 : 0];
    pathUniforms.screen.value.set(width, height);
    pathUniforms.breadth.value = Math.max(breadth, LEAST_BREADTH / ratio);
    this.resized(width, height, ratio);
  }

  private applyQuality(): void {
    this.dress();
    this.resize(this.size.width, this.size.height);
    this.renewShadows();
    this.changed();
  }

  /** Gives everything the materials and the light of the rung. */
  private dress(): void {
    const { shadows, shading } = this.rung;
    const standard = shading === 'standard';
    this.renderer.shadowMap.enabled = shadows;
    this.lights.castShadows(shadows);
    this.rim.mesh.visible = this.hasFloor && this.isFloorShown;
    this.shade.mesh.visible = this.rim.mesh.visible && !shadows;
    this.surfaces.setShading(shading);
    this.surfaces.refresh(this.world);
    if (standard) this.environment ??= makeEnvironment(this.renderer);
    this.scene.environment = standard ? this.environment : null;
    this.scene.environmentIntensity = LIGHT.reflection;
    this.lights.setEnvironment(standard);
  }
}
