/** The 3-D view: renderer, camera, lights, and what is in the world. */

import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { CSS2DRenderer } from 'three/addons/renderers/CSS2DRenderer.js';
import type { Frame, Scan } from '../protocol/frame';
import type { Scene, Vector } from '../protocol/scene';
import { MapView } from './map';
import { type Layer, Overlay } from './overlay';
import { RobotFleet } from './robot';

export type CameraMode = 'orbit' | 'follow' | 'top';

/** Class and name of a robot by its number. */
export type Roster = (robot: number) => { name: string; class: string } | null;

const SKY = { light: 0xe9edf0, dark: 0x1c2126 };

export class View {
  private readonly renderer: THREE.WebGLRenderer;
  private readonly labels = new CSS2DRenderer();
  private readonly camera = new THREE.PerspectiveCamera(45, 1, 0.03, 300);
  private readonly controls: OrbitControls;
  private readonly stage = new THREE.Scene();
  /** z down, as the wire has it. */
  private readonly world = new THREE.Group();
  private readonly sun = new THREE.DirectionalLight(0xffffff, 2.2);
  private map: MapView | null = null;
  private overlay: Overlay | null = null;
  private fleets = new Map<string, RobotFleet>();
  private placed = new Map<string, number[]>();
  private readonly shown = new Map<Layer, boolean>();
  private frame: Frame | null = null;
  private mode: CameraMode = 'orbit';
  private followed: number | null = null;
  private stale = true;
  private drawn: number[] = [];

  constructor(
    private readonly canvas: HTMLCanvasElement,
    labels: HTMLElement,
    private readonly roster: Roster,
  ) {
    // Without a graphics card smooth edges and shadows would take most of the time.
    const software = isSoftware();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !software });
    this.renderer.setPixelRatio(software ? 1 : Math.min(2, window.devicePixelRatio));
    this.renderer.shadowMap.enabled = !software;
    this.labels.domElement.className = 'labels';
    labels.append(this.labels.domElement);
    THREE.Object3D.DEFAULT_UP.set(0, 0, 1);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-2.2, -2.4, 1.7);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.maxPolarAngle = Math.PI / 2 - 0.01;
    this.controls.minDistance = 0.1;
    this.controls.maxDistance = 150;
    this.controls.addEventListener('change', () => (this.stale = true));
    this.world.rotation.x = Math.PI;
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(2048, 2048);
    Object.assign(this.sun.shadow.camera, { left: -4, right: 4, top: 4, bottom: -4, near: 1, far: 30 });
    this.stage.add(this.world, new THREE.HemisphereLight(0xffffff, 0x8c8f94, 1.6), this.sun, this.sun.target);
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
    const draw = () => {
      requestAnimationFrame(draw);
      this.draw();
    };
    requestAnimationFrame(draw);
  }

  /** Takes another world. */
  setScene(scene: Scene): void {
    this.map?.dispose();
    this.overlay?.clear();
    this.fleets.forEach((fleet) => fleet.dispose());
    this.world.clear();
    this.map = new MapView(scene);
    this.overlay = new Overlay(scene);
    this.fleets = new Map(Object.entries(scene.classes).map(([name, robot]) => [name, new RobotFleet(robot)]));
    this.world.add(this.map.group, this.overlay.group, ...[...this.fleets.values()].map((fleet) => fleet.group));
    this.shown.forEach((shown, layer) => this.show(layer, shown));
    this.stale = true;
  }

  setFrame(frame: Frame): void {
    if (this.frame && frame.time < this.frame.time) this.overlay?.clear();
    this.frame = frame;
    this.stale = true;
  }

  setScan(scan: Scan): void {
    const robot = this.frame?.robots.find(({ id }) => id === scan.robot);
    const robotClass = this.fleets.get(this.roster(scan.robot)?.class ?? '')?.robotClass;
    if (robot && robotClass) this.overlay?.scan(scan, robot, robotClass);
  }

  setDark(dark: boolean): void {
    this.stage.background = new THREE.Color(dark ? SKY.dark : SKY.light);
    this.stage.fog = new THREE.Fog(this.stage.background, 30, 120);
    this.stale = true;
  }

  show(layer: Layer, shown: boolean): void {
    this.shown.set(layer, shown);
    if (layer === 'grid') {
      if (this.map) this.map.grid.visible = shown;
    } else {
      this.overlay?.show(layer, shown);
      if (layer === 'names') this.map?.showNames(shown);
    }
    this.stale = true;
  }

  /** Looks in another way, at a robot if there is one. */
  look(mode: CameraMode, robot: number | null): void {
    const changed = mode !== this.mode;
    this.mode = mode;
    this.followed = robot;
    this.controls.enableRotate = mode !== 'top';
    if (changed) {
      const place = this.placeOf(robot) ?? this.controls.target.clone();
      const distance = mode === 'follow' ? 2 : Math.max(3, this.camera.position.distanceTo(this.controls.target));
      this.controls.target.copy(place);
      if (mode === 'top') this.camera.position.set(place.x, place.y - 0.001, place.z + distance);
      else this.camera.position.set(place.x - 0.7 * distance, place.y - 0.7 * distance, place.z + 0.6 * distance);
    }
    this.stale = true;
  }

  /** Turns to a robot that may be out of sight. */
  turnTo(robot: number): void {
    const place = this.placeOf(robot);
    if (!place) return;
    this.camera.position.add(place.clone().sub(this.controls.target));
    this.controls.target.copy(place);
    this.stale = true;
  }

  /** What is at a point of the screen: a robot by its number, or a place of the map in the wire's frame. */
  pick(x: number, y: number): { robot: number } | { place: Vector } | null {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const fleets = [...this.fleets].filter(([name]) => this.placed.get(name)?.length);
    const targets = [...fleets.map(([, fleet]) => fleet.group), ...(this.map ? [this.map.ground] : [])];
    const hit = ray.intersectObjects(targets, true)[0];
    if (!hit) return null;
    for (const [name, fleet] of fleets) {
      const index = fleet.robotAt(hit);
      const robot = index === null ? undefined : this.placed.get(name)?.[index];
      if (robot !== undefined) return { robot };
    }
    return { place: [hit.point.x, -hit.point.y, -hit.point.z] };
  }

  /** The picture as it is, as a PNG. */
  async screenshot(): Promise<Blob | null> {
    this.renderer.render(this.stage, this.camera);
    return new Promise((resolve) => this.canvas.toBlob(resolve, 'image/png'));
  }

  /** Frames drawn in the last second. */
  framesPerSecond(): number {
    const now = performance.now();
    this.drawn = this.drawn.filter((time) => time > now - 1000);
    return this.drawn.length;
  }

  /** Length in metres of 100 pixels where the camera looks. */
  metresPer100Pixels(): number {
    const distance = this.camera.position.distanceTo(this.controls.target);
    return (100 * 2 * distance * Math.tan(((this.camera.fov / 2) * Math.PI) / 180)) / this.canvas.clientHeight;
  }

  /** Where a robot is on the stage. */
  private placeOf(robot: number | null): THREE.Vector3 | null {
    const pose = this.frame?.robots.find(({ id }) => id === robot)?.pose;
    return pose ? new THREE.Vector3(pose[0], -pose[1], -pose[2]) : null;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.labels.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.stale = true;
  }

  private draw(): void {
    if (!this.stale || !this.map) return;
    this.stale = false;
    if (this.frame) this.place(this.frame);
    this.controls.update();
    this.renderer.render(this.stage, this.camera);
    this.labels.render(this.stage, this.camera);
    this.drawn.push(performance.now());
    if (this.drawn.length > 200) this.framesPerSecond();
  }

  private place(frame: Frame): void {
    for (const [name, fleet] of this.fleets) {
      const robots = frame.robots.filter(({ id }) => this.roster(id)?.class === name);
      fleet.place(robots);
      this.placed.set(
        name,
        robots.map(({ id }) => id),
      );
    }
    this.map?.place(frame.objects);
    this.overlay?.place(frame, this.roster);
    const place = this.mode === 'orbit' ? null : this.placeOf(this.followed);
    if (place) {
      this.camera.position.add(place.clone().sub(this.controls.target));
      this.controls.target.copy(place);
    }
    this.sun.target.position.copy(this.controls.target);
    this.sun.position.copy(this.controls.target).add(new THREE.Vector3(-4, 3, 9));
  }
}

/** Whether the browser draws without a graphics card. */
function isSoftware(): boolean {
  const gl = document.createElement('canvas').getContext('webgl2');
  const info = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = gl && info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}
