/** What is drawn over the world: paths, rays, contact forces, frames, names. */

import * as THREE from 'three';
import type { CSS2DObject } from 'three/addons/renderers/CSS2DRenderer.js';
import type { Frame, RobotState, Scan } from '../protocol/frame';
import type { RobotClass, Scene, Sensor } from '../protocol/scene';
import { label } from './map';
import { setPose } from './pose';

/** Places of a path that are kept, and the least distance between two, m. */
const PATH_PLACES = 4000;
const PATH_STEP = 0.005;
/** Length of the arrow of a force of 1 N, m. */
const FORCE_LENGTH = 0.004;
/** Length of the axes of a robot's and of a sensor's frame, m. */
const ROBOT_AXES = 0.3;
const SENSOR_AXES = 0.12;
/** Of so many beams of a laser one is drawn. */
const RAY_STEP = 6;
/** Ends of beams that differ by less in range are joined, m. */
const SAME_SURFACE = 0.15;
const X = new THREE.Vector3(1, 0, 0);

export const COLOURS = ['#e4572e', '#2f7dd1', '#2e9e5b', '#b0489c', '#c79a00', '#4bb3c4', '#8a5ad1', '#7a7a7a'];

export function colourOf(robot: number): string {
  return COLOURS[robot % COLOURS.length] ?? '#7a7a7a';
}

/** Line segments whose number changes from frame to frame. Where they begin can be marked by a point. */
class Segments {
  readonly lines: THREE.LineSegments;
  readonly points: THREE.Points | null = null;
  private places = new Float32Array(0);
  private count = 0;

  constructor(material: THREE.LineBasicMaterialParameters, pointSize = 0) {
    const geometry = new THREE.BufferGeometry();
    this.lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ transparent: true, ...material }));
    this.lines.frustumCulled = false;
    if (pointSize > 0) {
      const { color, depthTest = true } = material;
      // Transparent things are drawn last, over the floor.
      const dots = new THREE.PointsMaterial({
        transparent: true,
        ...(color && { color }),
        depthTest,
        size: pointSize,
        sizeAttenuation: false,
      });
      this.points = new THREE.Points(new THREE.BufferGeometry(), dots);
      this.points.frustumCulled = false;
      this.lines.add(this.points);
    }
  }

  begin(): void {
    this.count = 0;
  }

  add(from: THREE.Vector3, to: THREE.Vector3): void {
    if (6 * (this.count + 1) > this.places.length) {
      const more = new Float32Array(Math.max(600, 2 * this.places.length));
      more.set(this.places);
      this.places = more;
      this.lines.geometry.setAttribute('position', new THREE.BufferAttribute(more, 3));
      // Every second place: where a line begins.
      const starts = new THREE.InterleavedBuffer(more, 6);
      this.points?.geometry.setAttribute('position', new THREE.InterleavedBufferAttribute(starts, 3, 0));
    }
    from.toArray(this.places, 6 * this.count);
    to.toArray(this.places, 6 * this.count + 3);
    this.count++;
  }

  end(): void {
    this.lines.geometry.setDrawRange(0, 2 * this.count);
    const places = this.lines.geometry.getAttribute('position') as THREE.BufferAttribute | undefined;
    if (places) places.needsUpdate = true;
    const starts = this.points?.geometry.getAttribute('position') as THREE.InterleavedBufferAttribute | undefined;
    if (starts) starts.data.needsUpdate = true;
    this.points?.geometry.setDrawRange(0, this.count);
  }
}

class Path {
  readonly line: THREE.Line;
  private readonly places = new THREE.BufferAttribute(new Float32Array(3 * PATH_PLACES), 3);
  private count = 0;
  private last = new THREE.Vector3(Infinity, 0, 0);

  constructor(colour: string) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', this.places);
    geometry.setDrawRange(0, 0);
    this.line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: colour }));
    this.line.frustumCulled = false;
  }

  add(x: number, y: number, z: number): void {
    const place = new THREE.Vector3(x, y, z);
    if (place.distanceTo(this.last) < PATH_STEP) return;
    if (this.count === PATH_PLACES) {
      // The older half goes.
      this.places.array.copyWithin(0, 3 * (PATH_PLACES / 2));
      this.count = PATH_PLACES / 2;
    }
    this.last = place;
    place.toArray(this.places.array, 3 * this.count++);
    this.places.needsUpdate = true;
    this.line.geometry.setDrawRange(0, this.count);
  }
}

/** What belongs to one robot. */
interface Marks {
  path: Path;
  name: CSS2DObject;
  /** By the place of their sensor in the class's list. */
  scans: Map<number, Segments>;
}

export const LAYERS = ['paths', 'rays', 'forces', 'frames', 'names', 'grid'] as const;
export type Layer = (typeof LAYERS)[number];

export class Overlay {
  readonly group = new THREE.Group();
  private readonly marks = new Map<number, Marks>();
  private readonly paths = new THREE.Group();
  private readonly names = new THREE.Group();
  private readonly rays = new THREE.Group();
  private readonly forces = new Segments({ color: 0x17a05d, depthTest: false }, 6);
  private readonly axes = [0xd92b2b, 0x2e9e5b, 0x2f5fd1].map((color) => new Segments({ color, depthTest: false }));
  private readonly layers: Record<Exclude<Layer, 'grid'>, THREE.Object3D[]>;

  constructor(private readonly scene: Scene) {
    this.layers = {
      paths: [this.paths],
      rays: [this.rays],
      forces: [this.forces.lines],
      frames: this.axes.map((axis) => axis.lines),
      names: [this.names],
    };
    this.group.add(...Object.values(this.layers).flat());
  }

  show(layer: Exclude<Layer, 'grid'>, shown: boolean): void {
    this.layers[layer].forEach((object) => (object.visible = shown));
  }

  /** Draws what a laser or sonar measured, where it stood when it did: every beam's end, and some of the beams. */
  scan({ robot: id, sensor: index, ranges }: Scan, robot: RobotState, robotClass: RobotClass): void {
    const marks = this.marks.get(id);
    const sensor = robotClass.sensors[index];
    if (!marks || !sensor?.max_range || !this.rays.visible) return;
    let rays = marks.scans.get(index);
    if (!rays) {
      rays = new Segments({ color: 0xd92b2b, opacity: 0.5, depthWrite: false });
      marks.scans.set(index, rays);
      this.rays.add(rays.lines);
    }
    const mount = mountOf(sensor, robot);
    const origin = new THREE.Vector3().setFromMatrixPosition(mount);
    // From the right to the left; z is down, so the right is positive.
    const axis = new THREE.Vector3(0, sensor.fan && !sensor.fan.level ? 1 : 0, sensor.fan?.level === false ? 0 : 1);
    const range = sensor.max_range;
    rays.begin();
    let last: { end: THREE.Vector3; part: number } | null = null;
    ranges.forEach((part, beam) => {
      const angle = sensor.fan ? sensor.fan.first - beam * sensor.fan.resolution : 0;
      const end = X.clone()
        .applyAxisAngle(axis, angle)
        .multiplyScalar(part * range);
      end.applyMatrix4(mount);
      if (beam % RAY_STEP === 0 || beam === ranges.length - 1) rays.add(origin, end);
      if (last && Math.abs(part - last.part) * range < SAME_SURFACE) rays.add(last.end, end);
      last = { end, part };
    });
    rays.end();
  }

  place(frame: Frame, classOf: (robot: number) => { name: string; class: string } | null): void {
    for (const [id, marks] of this.marks) {
      if (!frame.robots.some((robot) => robot.id === id)) this.remove(id, marks);
    }
    const moving = [this.forces, ...this.axes];
    moving.forEach((segments) => segments.begin());
    for (const robot of frame.robots) {
      const known = classOf(robot.id);
      const robotClass = known && this.scene.classes[known.class];
      if (!known || !robotClass) continue;
      this.placeRobot(robot, known.name || known.class, robotClass);
    }
    moving.forEach((segments) => segments.end());
  }

  /** Forgets everything that was: a fresh world. */
  clear(): void {
    this.marks.forEach((marks, id) => this.remove(id, marks));
  }

  private placeRobot(robot: RobotState, name: string, robotClass: RobotClass): void {
    const marks = this.marks.get(robot.id) ?? this.add(robot.id, name);
    const [x, y, z] = robot.pose;
    marks.path.add(x, y, z + robotClass.wheel_radius * 0.3);
    marks.name.position.set(x, y, z - 0.45);
    if (this.axes[0]?.lines.visible) {
      const frame = setPose(new THREE.Matrix4(), robot.pose);
      this.placeAxes(frame, ROBOT_AXES);
      robotClass.sensors.forEach((sensor) => this.placeAxes(mountOf(sensor, robot), SENSOR_AXES));
    }
    if (!this.forces.lines.visible) return;
    for (const { point, force } of robot.contacts) {
      const from = new THREE.Vector3(...point);
      this.forces.add(from, from.clone().addScaledVector(new THREE.Vector3(...force), FORCE_LENGTH));
    }
  }

  private placeAxes(frame: THREE.Matrix4, length: number): void {
    const origin = new THREE.Vector3().setFromMatrixPosition(frame);
    this.axes.forEach((segments, axis) => {
      segments.add(origin, new THREE.Vector3().setComponent(axis, length).applyMatrix4(frame));
    });
  }

  private add(id: number, name: string): Marks {
    const marks = { path: new Path(colourOf(id)), name: label(name, 'name robot'), scans: new Map<number, Segments>() };
    marks.name.element.style.borderColor = colourOf(id);
    this.paths.add(marks.path.line);
    this.names.add(marks.name);
    this.marks.set(id, marks);
    return marks;
  }

  private remove(id: number, { path, name, scans }: Marks): void {
    scans.forEach(({ lines }) => {
      this.rays.remove(lines);
      lines.geometry.dispose();
      (lines.material as THREE.Material).dispose();
    });
    this.paths.remove(path.line);
    path.line.geometry.dispose();
    (path.line.material as THREE.Material).dispose();
    this.names.remove(name);
    this.marks.delete(id);
  }
}

/** Where a sensor is in the world. */
function mountOf({ link, pose }: Sensor, robot: RobotState): THREE.Matrix4 {
  const mount = setPose(new THREE.Matrix4(), pose);
  const carrier = link === null ? undefined : robot.links[link];
  if (carrier) mount.premultiply(setPose(new THREE.Matrix4(), carrier));
  return mount.premultiply(setPose(new THREE.Matrix4(), robot.pose));
}
