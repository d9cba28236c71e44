/** The 3-D view: what the page tells it and asks it. */

import * as THREE from 'three';
import type { Viewpoint } from '../link';
import type { Frame, Scan } from '../protocol/frame';
import type { Pose, Scene, Vector } from '../protocol/scene';
import { type CameraMode, Cameras } from './cameras';
import { COLOURS } from './colours';
import { Ghost } from './ghost';
import { Gizmo } from './gizmo';
import { type LabelKind, Labels } from './labels';
import { type Catalogue, MapView, objectsOf } from './map';
import { moved } from './moved';
import { Outline } from './outline';
import { type Layer, Overlay, mountOf } from './overlay';
import { onStage, onWire } from './pose';
import { type Led, Pulls } from './pulls';
import type { Quality } from './quality';
import { type Met, Robots, type Roster } from './robots';
import { labelMap, labelMetres, labelObjects, labelRobots, labelStarts } from './signs';
import { Stage } from './stage';
import { Still } from './still';
import { copyOf, cutOut } from './cutout';
import { Targets } from './targets';
import { frameRate } from './stopwatch';

export { CAMERAS, type CameraMode } from './cameras';
export type { Quality } from './quality';
export type { Roster } from './robots';

/** Half the edge of what is shown of a map without anything, m, and the room about a robot, in its lengths. */
const EMPTY_REACH = 2.5;
/** Edge of a map that is too large to be seen whole at first, m, and from where its starts are seen then. */
const LARGE = 60;
const ASIDE = new THREE.Vector3(-14, -11, 5);
const ROOM = 0.6;
/** Interval between two moves of labels, ms, without a graphics card and while the camera stands. The browser paints them each time. */
const LABEL_INTERVAL = 120;
/** A picture is not started while so many are not done. */
const MOST_BEHIND = 2;
/** Distance at which a line about a robot follows a coarse shape, over that at which the robot has one. */
const COARSER = 3;
/** Lines about the object under the pointer, and about the chosen one. */
const HOVERED = '#8fa3bd';
const CHOSEN = '#f0a020';
/** Rotation from a camera's axes (x right, y up, z back) to a sensor's (x ahead, y right, z down). */
const CAMERA_IN_SENSOR = new THREE.Matrix4().makeBasis(
  new THREE.Vector3(0, 1, 0),
  new THREE.Vector3(0, 0, -1),
  new THREE.Vector3(-1, 0, 0),
);

/** Robot with its link, null for the body, or object at a point of the screen, and its place there in the wire's frame; or the ground. */
type ThingHit = ({ robot: number; link: number | null } | { object: number }) & { place: Vector };
export type Hit = ThingHit | { ground: true; place: Vector };

/** Parts of a picture that is saved. */
export interface Looks {
  grid: boolean;
  floor: boolean;
  /** Sky; without it what is behind the world is transparent. */
  background: boolean;
  labels: boolean;
}

interface World {
  scene: Scene;
  map: MapView;
  robots: Robots;
  overlay: Overlay;
  targets: Targets;
  pulls: Pulls;
}

export class View {
  private readonly stage: Stage;
  private readonly cameras: Cameras;
  private readonly labels: Labels;
  private readonly gizmo: Gizmo;
  private readonly still: Still;
  private readonly outline = new Outline();
  /** About the object under the pointer. */
  private readonly hovering = new Outline();
  private led: Led | null = null;
  private hovered: number | null = null;
  private chosen: number | null = null;
  private readonly ghost = new Ghost();
  /** A robot of another run. */
  private readonly rival = new Ghost();
  private world: World | null = null;
  private readonly shown = new Map<Layer, boolean>();
  private frame: Frame | null = null;
  private drawnFrame: Frame | null = null;
  private looked: number | null = null;
  /** A robot that is framed as soon as it is there. */
  private fitting: number | null = null;
  private stale = true;
  /** Times of drawn frames, and of frames with nothing new, ms. */
  private drawn: number[] = [];
  private idle: number[] = [];
  private last = performance.now();
  /** Time of the labels' last move, ms. */
  private labelled = 0;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    labels: HTMLElement,
    private readonly roster: Roster,
    private readonly catalogue: Catalogue,
    private readonly colours: (robot: number) => string,
  ) {
    const refresh = () => this.stir();
    this.cameras = new Cameras(
      canvas,
      {
        surfaceAt: (x, y) => this.surfaceAt(x, y),
        robot: () => this.lookedRobot(),
        robotsEye: () => this.robotsEye(),
        hover: (x, y) => this.hover(this.thingAt(this.rayAt(x, y))),
        leave: () => this.hover(null),
      },
      refresh,
      (mode) => this.onCamera(mode),
    );
    const resized = (width: number, height: number, ratio: number) => this.setScreen(width, height, ratio);
    this.stage = new Stage(canvas, this.cameras.camera, () => this.bodiless(), resized, refresh);
    this.still = new Still(canvas, this.stage, () => this.placeFrame(1));
    this.labels = new Labels(labels, (place, kind) => this.isBehind(place, kind));
    this.gizmo = new Gizmo(labels, (yaw, pitch) => this.cameras.lookFrom(yaw, pitch));
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
    const draw = (now: number) => {
      requestAnimationFrame(draw);
      this.draw(now);
    };
    requestAnimationFrame(draw);
  }

  /** Takes another world. */
  setScene(scene: Scene): void {
    this.world?.map.dispose();
    this.world?.overlay.dispose();
    this.world?.targets.dispose();
    this.world?.pulls.dispose();
    this.world?.robots.dispose();
    this.outline.clear();
    this.hovering.clear();
    this.chosen = this.hovered = null;
    this.ghost.clear();
    this.rival.clear();
    this.labels.clear();
    this.stage.world.clear();
    this.frame = this.drawnFrame = null;
    const map = new MapView(scene, this.stage.surfaces, this.catalogue);
    const world = {
      scene,
      map,
      robots: new Robots(scene, this.stage.surfaces, this.roster, this.colours),
      overlay: new Overlay(this.colours),
      targets: new Targets(scene),
      pulls: new Pulls(this.labels),
    };
    if (this.world) world.robots.selected = this.world.robots.selected;
    this.world = world;
    world.overlay.select(world.robots.selected);
    const apart = [
      world.targets.group,
      world.pulls.group,
      this.outline.group,
      this.hovering.group,
      this.ghost.group,
      this.rival.group,
    ];
    this.stage.world.add(map.group, world.robots.group, world.overlay.group, ...apart);
    labelMap(this.labels, scene);
    labelObjects(this.labels, objectsOf(scene), this.catalogue);
    this.shown.forEach((shown, layer) => this.show(layer, shown));
    this.showFirst(scene);
    const first = scene.scenario?.camera ?? null;
    this.cameras.wasTouched = first !== null;
    if (first) this.cameras.place(onStage(first.from), onStage(first.at));
    this.stage.setGround(map.ground, this.mapExtent(), map.hasFloor);
    this.fitting = null;
    if (!this.stage.isSoftware) this.cameras.startTurntable();
    this.stage.renewShadows();
    this.resize();
  }

  setFrame(frame: Frame): void {
    if (this.frame && frame.time < this.frame.time) this.world?.overlay.clear();
    this.frame = frame;
    // With few pixels nobody sees a roller turn.
    const counted = { forces: this.shown.get('forces') === true, rollers: this.stage.sharpness >= 1 };
    const drawn = this.drawnFrame;
    const turned = frame.time !== drawn?.time && this.world?.robots.spin === true;
    if (drawn && !turned && !moved(drawn, frame, counted)) return;
    this.stir();
    this.stage.renewShadows();
  }

  /** Shows objects of which it is known now what they are. */
  renewObjects(): void {
    this.stir();
    this.stage.renewShadows();
  }

  setScan(scan: Scan): void {
    const robot = this.frame?.robots.find(({ id }) => id === scan.robot);
    const robotClass = this.world?.robots.classOf(scan.robot);
    if (!robot || !robotClass) return;
    this.world?.overlay.scan(scan, robot, robotClass);
    // The noise of a sensor is no motion, and no reason to draw under a still picture.
    if (!this.still.isBegun) this.stale = true;
  }

  show(layer: Layer, shown: boolean): void {
    this.shown.set(layer, shown);
    if (layer === 'grid') {
      this.stage.grid.mesh.visible = shown;
      this.labels.layers.metres = shown;
    } else if (layer === 'depth') this.stage.showDepths(shown);
    else if (layer === 'names') {
      Object.assign(this.labels.layers, { robot: shown, start: shown, node: shown, object: shown });
    } else if (layer === 'goals') {
      this.labels.layers.goal = shown;
      if (this.world) this.world.targets.group.visible = shown;
    } else this.world?.overlay.show(layer, shown);
    this.stir();
  }

  /** Marks goals as reached, by their names. */
  setReached(goals: readonly string[]): void {
    this.world?.targets.setReached(goals);
    this.stir();
  }

  /** Looks in another way, at a robot if there is one. */
  look(mode: CameraMode, robot: number | null): void {
    this.looked = robot;
    this.cameras.look(mode);
  }

  /** Turns to a robot that may be out of sight. */
  turnTo(robot: number): void {
    const place = this.placeOf(robot);
    if (place) this.cameras.lookAt(place);
  }

  /** Turns to a movable object. */
  lookAtObject(number: number): void {
    const pose = this.frame?.objects.find((object) => object.number === number)?.pose;
    if (pose) this.lookAtPlace([pose[0], pose[1], pose[2]]);
  }

  /** Turns to a place of the world. */
  lookAtPlace(place: Vector): void {
    this.cameras.lookAt(onStage(place));
  }

  /** Shows a robot, or all of the map, as large as there is room, from the side from which it is seen now. */
  fit(robot: number | null): void {
    this.cameras.wasTouched = true;
    // A robot that has just come is shown with the next frame.
    this.fitting = robot !== null && !this.extentOf(robot) ? robot : null;
    if (this.fitting !== null) return;
    this.cameras.fit(robot === null ? this.extent() : (this.extentOf(robot) ?? this.extent()));
  }

  /** Tells which camera is on when that changes. */
  onCamera: (mode: CameraMode) => void = () => {};

  /**
   * Takes part in each frame of the browser in which there is time for a picture, at its time, ms. What changes the page then costs no frame of
   * its own: without a graphics card one takes as long as a picture.
   */
  onFrame: (now: number) => void = () => {};

  /** Shows the whole map as at first; the camera from above stays there. */
  home(): void {
    this.cameras.wasTouched = true;
    this.cameras.home(this.extent());
  }

  /** Draws a line about a robot, and its sensors' fans where that layer is shown. */
  select(robot: number | null): void {
    if (!this.world) return;
    this.world.robots.selected = robot;
    this.world.overlay.select(robot);
    this.stir();
  }

  /** Draws a line about an object in place of the robot. */
  chooseObject(number: number | null): void {
    this.chosen = number;
    this.stir();
  }

  /** True if the browser draws without a graphics card. */
  get isSoftware(): boolean {
    return this.stage.isSoftware;
  }

  /** True while a still picture is drawn. */
  get isRefining(): boolean {
    return this.still.isBegun && !this.still.isShown;
  }

  /** Holds a rung of quality, or lets it follow the time that a frame takes. */
  setQuality(quality: Quality | 'auto'): void {
    this.stage.ladder.set(quality);
    this.stir();
  }

  /** The rung of the ladder of quality that is shown, 1 to 5. */
  get quality(): Quality {
    return this.still.isShown ? 5 : this.stage.quality;
  }

  /** While something is dragged by the page, a pointer does not move the camera. */
  holdCamera(held: boolean): void {
    this.cameras.pointer.held = held;
  }

  /** Shows the way of a robot's link to the pointer that leads it; null for none. */
  showLed(led: Led | null): void {
    this.led = led;
    this.stir();
  }

  /** Time has changed without passing. */
  jump(): void {
    this.cameras.jump();
    this.clearPaths();
  }

  clearPaths(): void {
    this.world?.overlay.clearPaths();
    this.stir();
  }

  /** Returns what is at a point of the screen. */
  pick(x: number, y: number): Hit | null {
    const thing = this.thingAt(this.rayAt(x, y));
    if (thing) return thing;
    const place = this.groundAt(x, y);
    return place && { ground: true, place };
  }

  /** Returns the point under a point of the screen at the height of a place, or upright above and below it; null beside it. */
  pointAt(x: number, y: number, place: Vector, isUpright: boolean): Vector | null {
    const { ray } = this.rayAt(x, y);
    const through = onStage(place);
    const normal = isUpright ? ray.origin.clone().sub(through).setZ(0).normalize() : new THREE.Vector3(0, 0, 1);
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(normal, through);
    const hit = ray.intersectPlane(plane, new THREE.Vector3());
    // Near the horizon a pixel is many metres.
    if (!hit || hit.distanceTo(through) > 4 * this.cameras.distance) return null;
    return onWire(isUpright ? through.setZ(hit.z) : hit);
  }

  /** The ground at a point of the screen, whatever robot stands on it, in the wire's frame. */
  groundAt(x: number, y: number): Vector | null {
    const hit = this.groundHit(this.rayAt(x, y));
    return hit && onWire(hit.point);
  }

  /** True if nothing of the map stands between two places of the wire's frame, but for what is so near to the second, m. */
  sees(from: Vector, to: Vector, near: number): boolean {
    const [eye, place] = [onStage(from), onStage(to)];
    const towards = place.sub(eye);
    const far = towards.length() - near;
    return far <= 0 || this.groundHit(new THREE.Raycaster(eye, towards.normalize(), 0, far)) === null;
  }

  /** Shows a robot of a class as if it were put on the ground there, red where it cannot stand; or none. */
  showGhost(robotClass: string | null, place: Vector = [0, 0, 0], yaw = 0, fits = true): void {
    this.ghost.setFits(fits);
    const fleet = robotClass === null ? null : (this.world?.robots.fleet(robotClass) ?? null);
    const alike = this.world?.robots.all.find((known) => known.fleet === fleet);
    this.ghost.show(fleet, place, yaw, alike?.state ?? null, alike?.colour ?? COLOURS[0]);
    this.stir();
  }

  /** Shows a robot of a class where it was in another run; null for none. */
  showRival(robotClass: string, pose: Pose | null): void {
    if (!pose && !this.rival.group.visible) return;
    const fleet = pose && (this.world?.robots.fleet(robotClass) ?? null);
    this.rival.put(fleet, pose ?? [0, 0, 0, 0, 0, 0, 1]);
    this.stir();
  }

  /** Place of the camera and place that it looks at, in the wire's frame. */
  get viewpoint(): Viewpoint {
    return { from: onWire(this.cameras.eye), at: onWire(this.cameras.target) };
  }

  /** Looks from a place at another. */
  setViewpoint({ from, at }: Viewpoint): void {
    this.cameras.wasTouched = true;
    this.fitting = null;
    this.cameras.place(onStage(from), onStage(at));
    this.stir();
  }

  /**
   * Returns the picture as a PNG at the best quality, whatever rung is drawn with now: as large as is wanted, px, or with every pixel of the
   * screen.
   */
  async screenshot(size: { width: number; height: number } | null, looks: Partial<Looks>): Promise<Blob | null> {
    const before = this.stage.grid.mesh.visible;
    const { grid = before, floor = true, background = true, labels = false } = looks;
    const ratio = window.devicePixelRatio;
    this.stage.grid.mesh.visible = grid && floor;
    if (!floor) this.showFloor(false);
    this.stage.setSaving(true);
    if (size) this.resizeTo(size.width / ratio, size.height / ratio);
    else this.resize();
    this.placeFrame(1);
    const draw = () => {
      this.stage.render(this.cameras.target, this.cameras.distance);
      return copyOf(this.canvas);
    };
    let picture: HTMLCanvasElement;
    if (background) picture = draw();
    else {
      const [onBlack, onWhite] = ['#000000', '#ffffff'].map((colour) => {
        this.stage.setBackdrop(colour);
        return draw();
      }) as [HTMLCanvasElement, HTMLCanvasElement];
      this.stage.setBackdrop(null);
      picture = cutOut(onBlack, onWhite);
    }
    const context = picture.getContext('2d');
    if (labels && context) {
      this.labels.update(this.cameras.camera, this.cameras.distance);
      this.labels.drawOn(context, picture.width / (size ? size.width / ratio : this.canvas.clientWidth));
    }
    if (!floor) this.showFloor(true);
    this.stage.grid.mesh.visible = before;
    this.stage.setSaving(false);
    this.resize();
    return new Promise<Blob | null>((resolve) => picture.toBlob(resolve, 'image/png'));
  }

  private showFloor(shown: boolean): void {
    this.stage.showFloor(shown);
    this.world?.map.showFloor(shown);
    if (this.world) this.world.robots.decal.visible = shown;
  }

  /** Frames drawn in the last second; null at rest. */
  framesPerSecond(): number | null {
    const since = performance.now() - 1000;
    this.drawn = this.drawn.filter((time) => time > since);
    this.idle = this.idle.filter((time) => time > since);
    return frameRate(this.drawn.length, this.idle.length);
  }

  /** Distance of the camera from what it looks at, m. */
  get distance(): number {
    return this.cameras.distance;
  }

  /** Length in metres of 100 pixels where the camera looks. */
  metresPer100Pixels(): number {
    return 100 / this.pixelsPerMetre(this.cameras.distance);
  }

  /** Something else is to be seen. */
  private stir(): void {
    this.stale = true;
    this.still?.stir();
  }

  private draw(now: number): void {
    const seconds = Math.min(0.1, (now - this.last) / 1000);
    if (!this.world || this.stage.stopwatch.behind >= MOST_BEHIND) return;
    this.last = now;
    this.onFrame(now);
    if (!this.stale && !this.cameras.isMoving) {
      // With the last frame it may have been too soon to move them.
      if (this.labels.isBusy || this.labelled < (this.drawn.at(-1) ?? 0)) this.placeLabels(now);
      this.idle.push(now);
      if (this.idle.length > 200) this.framesPerSecond();
      this.still.rest(now);
      return;
    }
    if (this.cameras.isMoving) this.still.stir();
    this.stale = false;
    this.stage.rim.surround(this.extent());
    // Before, since the robots are drawn as they are seen from there; after, since it may follow them.
    this.placeFrame(this.stage.sharpness);
    this.frameRobots();
    this.cameras.update(seconds);
    this.stage.render(this.cameras.target, this.cameras.distance);
    if (this.labels.layers.metres) {
      labelMetres(this.labels, this.mapExtent(), this.cameras.eye, this.metresPer100Pixels());
    }
    if (!this.stage.isSoftware || this.cameras.isMoving || now - this.labelled > LABEL_INTERVAL) this.placeLabels(now);
    this.gizmo.update(this.cameras.camera);
    this.drawn.push(now);
    if (this.drawn.length > 200) this.framesPerSecond();
  }

  /** Frames a robot that has come, and the first robots of a world that nobody has turned yet. */
  private frameRobots(): void {
    if (this.fitting !== null && this.extentOf(this.fitting)) this.fit(this.fitting);
    const robots = this.world?.robots.all ?? [];
    if (this.cameras.wasTouched || robots.length === 0) return;
    this.cameras.wasTouched = true;
    const box = new THREE.Box3();
    for (const { state } of robots) box.union(this.extentOf(state.id) ?? new THREE.Box3());
    this.cameras.fit(box);
  }

  private placeLabels(now: number): void {
    this.labelled = now;
    this.labels.update(this.cameras.camera, this.cameras.distance);
  }

  /** Places what is in the frame, for a picture with so many pixels for one of the page. */
  private placeFrame(sharpness: number): void {
    if (this.world && this.frame) this.place(this.world, this.frame, sharpness);
  }

  private place({ scene, map, robots, overlay, pulls }: World, frame: Frame, sharpness: number): void {
    const { x, y, z } = this.cameras.eye;
    const eye = new THREE.Vector3(x, -y, -z);
    robots.place(frame, { eye, sharpness });
    map.place(frame.objects);
    labelObjects(this.labels, frame.objects, this.catalogue);
    overlay.place(frame, (id) => robots.classOf(id), eye);
    labelRobots(this.labels, robots);
    labelStarts(this.labels, scene, robots);
    pulls.place([...frame.pulls, ...(this.led ? [this.led] : [])], eye, this.pixelsPerMetre(1));
    this.hovering.place(map.outlined(this.hovered), HOVERED);
    const chosen = map.outlined(this.chosen);
    const selected = chosen.length > 0 ? null : robots.find(robots.selected);
    if (selected) {
      const [px, py, pz] = selected.state.pose;
      const distance = eye.distanceTo(new THREE.Vector3(px, py, pz));
      this.outline.suit(selected.fleet.size * this.pixelsPerMetre(Math.max(0.1, distance)));
    }
    // Of few pixels a coarse shape has the same line, and the line draws it twice.
    const coarse = sharpness < 1 ? sharpness / COARSER : sharpness;
    const parts = selected ? selected.fleet.parts(selected.state, { eye, sharpness: coarse }, frame.time) : chosen;
    this.outline.place(parts, selected ? this.colours(selected.state.id) : CHOSEN);
    this.drawnFrame = frame;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.resizeTo(width, height);
  }

  private resizeTo(width: number, height: number): void {
    this.cameras.resize(width, height);
    this.stage.resize(width, height);
    this.labels.resize(width, height);
    this.stir();
  }

  /** Sets the size of what is drawn on: of the view, or of a part of it. */
  private setScreen(width: number, height: number, ratio: number): void {
    this.outline.resize(width, height, ratio);
    this.hovering.resize(width, height, ratio);
    this.world?.overlay.resize(this.pixelsPerMetre(1), ratio);
  }

  private pixelsPerMetre(distance: number): number {
    return this.canvas.clientHeight / (2 * distance * Math.tan(((this.cameras.camera.fov / 2) * Math.PI) / 180));
  }

  private rayAt(x: number, y: number): THREE.Raycaster {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.cameras.camera);
    return ray;
  }

  private groundHit(ray: THREE.Raycaster): THREE.Intersection | null {
    return this.world ? (ray.intersectObject(this.world.map.ground, true)[0] ?? null) : null;
  }

  /** The robot or object that a ray meets before the ground, which is looked at only behind one: that takes longer. */
  private thingAt(ray: THREE.Raycaster): ThingHit | null {
    const [robot, object] = [this.meet(ray), this.world?.map.meet(ray) ?? null];
    const first = object && object.distance < (robot?.distance ?? Infinity) ? object : robot;
    if (!first) return null;
    ray.far = first.distance;
    if (this.groundHit(ray)) return null;
    const place = onWire(ray.ray.at(first.distance, new THREE.Vector3()));
    return 'robot' in first ? { robot: first.robot, link: first.link, place } : { object: first.object, place };
  }

  private meet(ray: THREE.Raycaster): Met | null {
    return this.world?.robots.meet(ray.ray.clone().applyMatrix4(this.stage.world.matrixWorld.clone().invert())) ?? null;
  }

  private surfaceAt(x: number, y: number): THREE.Vector3 | null {
    const ray = this.rayAt(x, y);
    const distances = [this.meet(ray)?.distance, this.groundHit(ray)?.distance].filter((far) => far !== undefined);
    return distances.length > 0 ? ray.ray.at(Math.min(...distances), new THREE.Vector3()) : null;
  }

  private isBehind(place: THREE.Vector3, kind: LabelKind): boolean {
    const eye = this.cameras.camera.position;
    const towards = place.clone().sub(eye);
    const far = towards.length() - 0.05;
    const ray = new THREE.Raycaster(eye, towards.normalize(), 0, far);
    // A robot's own name is above it, and other robots may be seen through: they move.
    if (kind !== 'robot' && (this.meet(ray)?.distance ?? Infinity) < far) return true;
    // Numbers lie on the floor, which is no wall.
    return kind !== 'metres' && this.groundHit(ray) !== null;
  }

  private hover(hit: ThingHit | null): void {
    const robot = hit && 'robot' in hit ? hit.robot : null;
    const object = hit && 'object' in hit ? hit.object : null;
    if (!this.world || (this.world.robots.hovered === robot && this.hovered === object)) return;
    this.world.robots.hovered = robot;
    this.hovered = object;
    this.canvas.classList.toggle('over-thing', robot !== null || object !== null);
    this.stir();
  }

  /** Returns the place of a robot on the stage. */
  private placeOf(robot: number | null): THREE.Vector3 | null {
    const pose = this.frame?.robots.find(({ id }) => id === robot)?.pose;
    return pose ? onStage([pose[0], pose[1], pose[2]]) : null;
  }

  private lookedRobot(): ReturnType<ConstructorParameters<typeof Cameras>[1]['robot']> {
    const [place, known] = [this.placeOf(this.looked), this.world?.robots.find(this.looked)];
    if (!place || !known) return null;
    const [, , , x, y, z, w] = known.state.pose;
    const ahead = new THREE.Vector3(1, 0, 0).applyQuaternion(new THREE.Quaternion(x, y, z, w));
    const size = known.fleet.bounds.getSize(new THREE.Vector3()).length();
    return { place, yaw: Math.atan2(-ahead.y, ahead.x), size };
  }

  /** Returns the view of the robot's own camera, or of its front if it has none. */
  private robotsEye(): THREE.Matrix4 | null {
    const known = this.world?.robots.find(this.looked);
    if (!known) return null;
    const { min, max } = known.fleet.bounds;
    const camera = known.fleet.robotClass.sensors.find(({ name }) => /cam/i.test(name));
    const front = { link: null, pose: [max.x + 0.02, 0, min.z + 0.02, 0, 0, 0, 1] as const };
    const mount = mountOf(camera ?? { ...front, pose: [...front.pose] }, known.state);
    return mount.multiply(CAMERA_IN_SENSOR).premultiply(this.stage.world.matrixWorld);
  }

  /** Returns the box of the map and the robots, with a margin. */
  private extent(): THREE.Box3 {
    return (this.frame?.robots ?? []).reduce((box, { id }) => box.union(this.extentOf(id) ?? box), this.mapExtent());
  }

  /** Shows the map as at first: what is around the starts of one that is so large that robots would be dots, as somebody there would see it. */
  private showFirst({ map: { starts } }: Scene): void {
    const whole = this.extent();
    const { x, y } = whole.getSize(new THREE.Vector3());
    this.cameras.home(whole, true);
    if (Math.max(x, y) <= LARGE || starts.length === 0) return;
    const places = starts.map(({ position }) => onStage(position));
    const middle = new THREE.Box3().setFromPoints(places).getCenter(new THREE.Vector3());
    this.cameras.place(middle.clone().add(ASIDE), middle);
  }

  /** Returns the box of the map's finite parts, with a margin. */
  private mapExtent(): THREE.Box3 {
    const box = this.world?.map.bounds.clone() ?? new THREE.Box3();
    if (box.isEmpty()) box.expandByPoint(new THREE.Vector3());
    const { x, y } = box.getSize(new THREE.Vector3());
    const room = Math.max(0.3, EMPTY_REACH - Math.max(x, y) / 2);
    box.expandByVector(new THREE.Vector3(room, room, 0));
    box.max.z = Math.max(box.max.z, 0.3);
    return box;
  }

  private extentOf(robot: number): THREE.Box3 | null {
    const [place, known] = [this.placeOf(robot), this.world?.robots.find(robot)];
    if (!place || !known) return null;
    const size = known.fleet.bounds.getSize(new THREE.Vector3()).length();
    return new THREE.Box3().setFromCenterAndSize(place, new THREE.Vector3(1, 1, 0.6).multiplyScalar(size * (1 + ROOM)));
  }

  private bodiless(): THREE.Object3D[] {
    const { map, robots, overlay, targets, pulls } = this.world ?? {};
    const decals = [...(map?.decals ?? []), ...(robots ? [robots.decal] : []), ...(map ? [map.starts] : [])];
    return [
      ...decals,
      ...(overlay ? [overlay.group] : []),
      ...(targets ? [targets.group] : []),
      ...(pulls ? [pulls.group] : []),
      this.outline.group,
      this.hovering.group,
      this.ghost.group,
      this.rival.group,
    ];
  }
}
