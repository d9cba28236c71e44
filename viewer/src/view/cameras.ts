/** The camera and its ways: by hand, after a robot, behind it, from above, from the robot itself. */

import * as THREE from 'three';
import { Pointer } from './pointer';
import {
  type Aim,
  anchor,
  applyAim,
  between,
  copyAim,
  eyeOf,
  fitted,
  GREATEST_DISTANCE,
  keepAbove,
  pan,
  turn,
  zoom,
} from './rig';

export const CAMERAS = ['orbit', 'follow', 'chase', 'top', 'robot'] as const;
export type CameraMode = (typeof CAMERAS)[number];

/** Questions of the camera about the world; places are on the stage. */
export interface Surroundings {
  /** Returns the place at a point of the screen. */
  surfaceAt(x: number, y: number): THREE.Vector3 | null;
  /** Returns the place of the selected robot, and its direction over the ground. */
  robot(): { place: THREE.Vector3; yaw: number; size: number } | null;
  /** Returns the matrix of a robot's own camera. */
  robotsEye(): THREE.Matrix4 | null;
  hover(x: number, y: number): void;
  leave(): void;
}

const FOV = 42;
/** A flight takes so long, s. */
const FLIGHT = 0.25;
/** Time constants: of the fading of a hand's movement, and of the camera behind a robot, s. */
const DAMPING = 0.055;
const LAG = 0.32;
/** A turn over the picture's whole height, rad. */
const HAND_TURN = Math.PI;
/** Distances from the middle of the view, parts of half the view: a robot that goes beyond the first one takes the view along, unless it was
 * beyond the second. */
const [EDGE, GONE] = [0.85, 1.3];
/** First view of the map: angles, rad, and the part of the picture that it fills. */
const FIRST = { yaw: 0.92, pitch: 0.66 };
const FILL = 0.9;
/** Angles of the camera from above, rad. */
const ABOVE = { yaw: Math.PI / 2, pitch: Math.PI / 2 };
/** Until someone touches the picture it turns by a quarter in so long, s. */
const TURNTABLE = 40;
/** Less than that is no movement: rad, parts of a distance. */
const STILL = 1e-4;

export class Cameras {
  readonly camera = new THREE.PerspectiveCamera(FOV, 1, 0.05, 800);
  readonly pointer: Pointer;
  mode: CameraMode = 'orbit';
  private aim: Aim = { target: new THREE.Vector3(), ...FIRST, distance: 8 };
  private flight: { from: Aim; to: Aim; part: number } | null = null;
  /** Rest of the hand's movement: rad, and the logarithm of a distance's factor. */
  private readonly rest = { yaw: 0, pitch: 0, zoom: 0 };
  private about = new THREE.Vector3();
  /** Rest of the first quarter turn, rad. */
  private turntable = 0;
  private lastRobot: THREE.Vector3 | null = null;
  private lagging = false;

  constructor(
    canvas: HTMLCanvasElement,
    private readonly world: Surroundings,
    private readonly changed: () => void,
    private readonly switched: (mode: CameraMode) => void,
  ) {
    this.pointer = new Pointer(canvas, {
      begin: (x, y) => this.begin(x, y),
      turn: (x, y) => this.move(() => ((this.rest.yaw -= x * HAND_TURN), (this.rest.pitch += y * HAND_TURN))),
      pan: (x, y) => this.move(() => this.shift(x, y)),
      zoom: (factor, x, y) => this.move(() => this.zoomTo(factor, x, y)),
      hover: (x, y) => world.hover(x, y),
      leave: () => world.leave(),
    });
    this.camera.up.set(0, 0, 1);
  }

  /** True once somebody has chosen what to look at. */
  wasTouched = false;

  get target(): THREE.Vector3 {
    return this.aim.target;
  }

  get distance(): number {
    return this.aim.distance;
  }

  /** True if it moves by itself. */
  get isMoving(): boolean {
    const { yaw, pitch, zoom: factor } = this.rest;
    const rest = Math.abs(yaw) + Math.abs(pitch) + Math.abs(factor) > STILL;
    return this.flight !== null || rest || this.turntable > 0 || this.lagging;
  }

  /** A slow quarter turn until the first touch. */
  startTurntable(): void {
    if (!wantsLessMotion()) this.turntable = Math.PI / 2;
  }

  /** Looks at a place from another, both on the stage, at once. */
  place(from: THREE.Vector3, at: THREE.Vector3): void {
    this.switchTo('orbit');
    const way = at.clone().sub(from);
    const yaw = Math.atan2(way.y, way.x);
    const pitch = Math.asin(-way.z / way.length());
    this.fly({ target: at, yaw, pitch, distance: way.length() }, true);
  }

  resize(width: number, height: number): void {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  look(mode: CameraMode): void {
    const [before, robot] = [this.mode, this.world.robot()];
    this.switchTo(mode);
    this.lastRobot = robot?.place ?? null;
    this.changed();
    if (mode === before && mode !== 'follow') return;
    this.wasTouched = true;
    const aim = copyAim(this.goal);
    if (mode === 'top') Object.assign(aim, ABOVE);
    else if (before === 'top') Object.assign(aim, FIRST);
    if (robot && (mode === 'follow' || mode === 'chase')) {
      aim.target.copy(robot.place);
      aim.distance = Math.max(6 * robot.size, Math.min(aim.distance, 10 * robot.size));
    }
    if (mode === 'chase') Object.assign(aim, { pitch: 0.42, distance: robot ? 5.5 * robot.size : aim.distance });
    this.fly(aim);
  }

  /** Looks at the same place from another side. */
  lookFrom(yaw: number | null, pitch: number): void {
    this.fly({ ...copyAim(this.goal), yaw: yaw ?? this.goal.yaw, pitch });
  }

  /** Looks at another place from the same side. */
  lookAt(place: THREE.Vector3): void {
    this.lastRobot = this.world.robot()?.place ?? null;
    this.fly({ ...copyAim(this.goal), target: place.clone() });
  }

  /** A robot's next place is one to which it did not drive: it takes the view along only if the view follows it. */
  jump(): void {
    if (!this.followsRobot) this.lastRobot = null;
  }

  private switchTo(mode: CameraMode): void {
    this.mode = mode;
    this.pointer.pansFirst = mode === 'top';
    this.switched(mode);
  }

  fit(box: THREE.Box3, jump = false): void {
    const { fov, aspect } = this.camera;
    const aim = fitted(this.goal, box, (fov * Math.PI) / 180, aspect, FILL);
    aim.distance = Math.min(GREATEST_DISTANCE, aim.distance);
    this.fly(aim, jump);
  }

  /** Shows all of a box as at first; the camera from above stays above. */
  home(box: THREE.Box3, jump = false): void {
    this.switchTo(this.mode === 'top' ? 'top' : 'orbit');
    const from = copyAim(this.aim);
    Object.assign(this.aim, this.mode === 'top' ? ABOVE : FIRST);
    this.flight = null;
    this.fit(box, jump);
    if (this.flight) (this.flight as { from: Aim }).from = from;
    if (!jump) this.aim = from;
  }

  /** Goes on by some seconds. */
  update(seconds: number): void {
    this.moveByHand(seconds);
    if (this.turntable > 0) {
      const part = Math.min(this.turntable, (seconds / TURNTABLE) * (Math.PI / 2));
      this.turntable -= part;
      turn(this.aim, this.aim.target, part, 0);
    }
    this.moveWithRobot(seconds);
    if (this.flight) {
      this.flight.part = Math.min(1, this.flight.part + seconds / FLIGHT);
      const { from, to, part } = this.flight;
      this.aim = between(from, to, part * part * (3 - 2 * part));
      if (part === 1) this.flight = null;
    }
    this.apply();
  }

  /** Pose of the camera now, or soon. */
  private get goal(): Aim {
    return this.flight?.to ?? this.aim;
  }

  private apply(): void {
    const { camera, aim } = this;
    const own = this.mode === 'robot' ? this.world.robotsEye() : null;
    if (own) own.decompose(camera.position, camera.quaternion, camera.scale);
    else applyAim(aim, camera);
    const near = own ? 0.02 : Math.min(0.5, Math.max(0.02, 0.03 * aim.distance));
    if (Math.abs(near - camera.near) > 0.1 * camera.near) {
      camera.near = near;
      camera.updateProjectionMatrix();
    }
    camera.updateMatrixWorld();
  }

  private moveByHand(seconds: number): void {
    const part = wantsLessMotion() ? 1 : 1 - Math.exp(-seconds / DAMPING);
    const { yaw, pitch, zoom: factor } = this.rest;
    if (Math.abs(yaw) + Math.abs(pitch) > STILL) turn(this.aim, this.about, yaw * part, pitch * part);
    if (Math.abs(factor) > STILL) zoom(this.aim, this.about, Math.exp(factor * part));
    const left = (value: number) => (Math.abs(value) > STILL ? value * (1 - part) : 0);
    Object.assign(this.rest, { yaw: left(yaw), pitch: left(pitch), zoom: left(factor) });
  }

  private moveWithRobot(seconds: number): void {
    const robot = this.mode === 'robot' ? null : this.world.robot();
    this.lagging = false;
    if (!robot) return;
    const last = this.lastRobot ?? robot.place;
    const moved = robot.place.clone().sub(last);
    this.lastRobot = robot.place;
    if (!this.followsRobot && !this.isLeaving(last, robot.place)) return;
    for (const place of [this.aim.target, this.about, this.flight?.to.target, this.flight?.from.target])
      place?.add(moved);
    if (this.mode !== 'chase' || this.flight) return;
    const part = wantsLessMotion() ? 1 : 1 - Math.exp(-seconds / LAG);
    const [far, way] = [robot.place.clone().sub(this.aim.target), robot.yaw - this.aim.yaw];
    this.aim.target.addScaledVector(far, part);
    const turned = Math.atan2(Math.sin(way), Math.cos(way));
    this.aim.yaw += turned * part;
    this.lagging = Math.abs(turned) > 0.002 || far.length() > 0.002;
  }

  /** True if what moves from one place to another leaves the view. Where pictures are few it may be far outside in the next one. */
  private isLeaving(from: THREE.Vector3, to: THREE.Vector3): boolean {
    const [before, after] = [from, to].map((place) => {
      const { x, y, z } = place.clone().project(this.camera);
      return z < 1 ? Math.max(Math.abs(x), Math.abs(y)) : Infinity;
    }) as [number, number];
    return after > before && after > EDGE && before < GONE;
  }

  private begin(x: number, y: number): void {
    this.wasTouched = true;
    this.stop();
    this.about = this.followsRobot ? this.aim.target.clone() : (this.world.surfaceAt(x, y) ?? this.aim.target.clone());
    if (!this.followsRobot) anchor(this.aim, this.about);
  }

  private zoomTo(factor: number, x: number, y: number): void {
    if (Math.abs(this.rest.zoom) < 0.01) this.begin(x, y);
    this.rest.zoom += Math.log(factor);
  }

  private shift(x: number, y: number): void {
    pan(this.aim, x, y, (this.camera.fov * Math.PI) / 180);
    keepAbove(this.aim);
  }

  private get followsRobot(): boolean {
    return (this.mode === 'follow' || this.mode === 'chase') && this.world.robot() !== null;
  }

  private move(how: () => void): void {
    how();
    this.changed();
  }

  /** A touch ends what it does by itself. */
  private stop(): void {
    this.turntable = 0;
    this.flight = null;
  }

  private fly(to: Aim, jump = false): void {
    keepAbove(to);
    this.turntable = 0;
    Object.assign(this.rest, { yaw: 0, pitch: 0, zoom: 0 });
    if (jump || wantsLessMotion()) {
      this.aim = to;
      this.flight = null;
    } else this.flight = { from: copyAim(this.aim), to, part: 0 };
    this.changed();
  }

  /** Place of the camera on the stage. */
  get eye(): THREE.Vector3 {
    return this.mode === 'robot' ? this.camera.position : eyeOf(this.aim);
  }
}

function wantsLessMotion(): boolean {
  return matchMedia('(prefers-reduced-motion: reduce)').matches;
}
