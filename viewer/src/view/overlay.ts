/** Overlay of the world: paths, scans, contacts, frames. */

import * as THREE from 'three';
import { type Contact, type Frame, type RobotState, type Scan, isHit } from '../protocol/frame';
import type { RobotClass, Sensor, Wheel } from '../protocol/scene';
import { Arrows } from './arrows';
import { Axes } from './axes';
import { FORCE_COLOURS } from './colours';
import { Patches } from './patches';
import { Path } from './paths';
import { PointCloud } from './points';
import { setPose } from './pose';
import { Rays, coneGeometry, fanGeometry } from './rays';

export const LAYERS = ['paths', 'points', 'rays', 'forces', 'frames', 'names', 'goals', 'grid', 'depth'] as const;
export type Layer = (typeof LAYERS)[number];
/** Layers that are shown by default. */
export const FIRST_LAYERS: readonly Layer[] = ['paths', 'points', 'names', 'goals', 'grid'];

/** Length of the axes of a robot's and of a sensor's frame, m. */
const ROBOT_AXES = 0.3;
const SENSOR_AXES = 0.12;
/** Length of an arrow for each tenfold of a force, m, and the least force that is drawn, N. */
const FORCE_LENGTH = 0.13;
const LEAST_FORCE = 0.5;
/** Length of an arrow for each tenfold of a slip in mm/s, m, and the least slip that is drawn, m/s. */
const SLIP_LENGTH = 0.06;
const LEAST_SLIP = 0.002;
const [HOLDS, SLIDES] = FORCE_COLOURS.map((colour) => new THREE.Color(colour)) as [THREE.Color, THREE.Color];
/** A path lies so far above the floor, m. */
const PATH_HEIGHT = 0.008;

type ClassOf = (robot: number) => RobotClass | null;
type OwnLayer = Exclude<Layer, 'grid' | 'names' | 'goals' | 'depth'>;

export class Overlay {
  readonly group = new THREE.Group();
  private readonly paths = new Map<number, Path>();
  private readonly pathGroup = new THREE.Group();
  private readonly cloud = new PointCloud();
  private readonly rays = new Rays();
  private readonly forces = new Arrows();
  private readonly patches = new Patches();
  private readonly axes = new Axes();
  private readonly layers: Record<OwnLayer, THREE.Object3D>;
  /** Keys of what each robot's sensors have drawn. */
  private readonly scanned = new Map<number, Set<string>>();
  private selected: number | null = null;

  constructor(private readonly colourOf: (robot: number) => string) {
    this.layers = {
      paths: this.pathGroup,
      points: this.cloud.points,
      rays: this.rays.group,
      forces: this.forces.group,
      frames: this.axes.lines,
    };
    this.forces.group.add(this.patches.mesh);
    this.group.add(...Object.values(this.layers));
  }

  show(layer: OwnLayer, shown: boolean): void {
    this.layers[layer].visible = shown;
  }

  /** The robot whose fans and cones are drawn. */
  select(robot: number | null): void {
    if (robot !== this.selected) this.rays.clear();
    this.selected = robot;
  }

  /** Sets how large points are for a picture of so many pixels. */
  resize(pixelsPerMetre: number, ratio: number): void {
    this.cloud.uniforms.pixelsPerMetre.value = pixelsPerMetre;
    this.cloud.uniforms.ratio.value = ratio;
    this.forces.pixelsPerMetre = pixelsPerMetre;
  }

  /** Draws what a laser or sonar measured, where it stood when it did. */
  scan({ robot: id, sensor: index, ranges }: Scan, robot: RobotState, robotClass: RobotClass): void {
    const sensor = robotClass.sensors[index];
    if (!sensor?.max_range) return;
    const key = `${id} ${index}`;
    this.scanned.set(id, (this.scanned.get(id) ?? new Set()).add(key));
    const mount = mountOf(sensor, robot);
    const colour = new THREE.Color(this.colourOf(id));
    const ends = beamEnds(sensor, ranges, mount);
    if (sensor.fan) {
      const hits = ranges.flatMap((part, beam) => (isHit(part) ? [...ends.subarray(3 * beam, 3 * beam + 3)] : []));
      this.cloud.set(key, Float32Array.from(hits), colour);
    }
    if (id !== this.selected || !this.rays.group.visible) return;
    const origin = new THREE.Vector3().setFromMatrixPosition(mount);
    const range = Math.max(...ranges) * sensor.max_range;
    this.rays.set(key, sensor.fan ? fanGeometry(origin, ends) : coneGeometry(mount, range), colour);
  }

  /** Shows a frame as it is seen from a place of the world. */
  place(frame: Frame, classOf: ClassOf, eye: THREE.Vector3): void {
    this.forces.eye.copy(eye);
    const present = new Set(frame.robots.map(({ id }) => id));
    for (const id of [...this.paths.keys(), ...this.scanned.keys()]) if (!present.has(id)) this.remove(id);
    this.forces.begin();
    this.patches.begin();
    this.axes.begin();
    for (const robot of frame.robots) {
      const robotClass = classOf(robot.id);
      if (robotClass) this.placeRobot(robot, robotClass);
    }
    this.forces.end();
    this.patches.end();
    this.axes.end();
    this.cloud.update();
  }

  clearPaths(): void {
    this.paths.forEach((path) => path.clear());
  }

  /** Forgets everything that was: a fresh world. */
  clear(): void {
    for (const id of [...this.paths.keys(), ...this.scanned.keys()]) this.remove(id);
  }

  dispose(): void {
    this.clear();
    [this.cloud, this.rays, this.forces, this.patches, this.axes].forEach((layer) => layer.dispose());
  }

  private placeRobot(robot: RobotState, robotClass: RobotClass): void {
    this.pathOf(robot.id).add(...footOf(robot, robotClass));
    if (this.axes.lines.visible) {
      this.axes.add(setPose(new THREE.Matrix4(), robot.pose), ROBOT_AXES);
      robotClass.sensors.forEach((sensor) => this.axes.add(mountOf(sensor, robot), SENSOR_AXES));
    }
    if (!this.forces.group.visible) return;
    for (const contact of robot.contacts) this.placeContact(contact, robot, robotClass);
  }

  /** Draws the force of a contact, coloured by the part of its friction that it uses, its slip, and the patch of a tyre. */
  private placeContact({ point, force, wheel, slip, share }: Contact, robot: RobotState, { wheels }: RobotClass): void {
    const [along, at] = [new THREE.Vector3(...force), new THREE.Vector3(...point)];
    const strength = along.length();
    if (strength < LEAST_FORCE) return;
    const colour = HOLDS.clone().lerp(SLIDES, share);
    this.forces.add(at, along.divideScalar(strength), FORCE_LENGTH * Math.log10(1 + strength), colour);
    const over = new THREE.Vector3(...slip);
    const speed = over.length();
    if (speed > LEAST_SLIP) {
      this.forces.add(at, over.divideScalar(speed), SLIP_LENGTH * Math.log10(1 + 1000 * speed), SLIDES);
    }
    const ofClass = wheel === null ? undefined : wheels[wheel];
    if (ofClass?.patch) this.patches.add(at, ...patchAxes(ofClass, ofClass.patch, at, robot), colour);
  }

  private pathOf(id: number): Path {
    const known = this.paths.get(id);
    if (known) return known;
    const path = new Path(this.colourOf(id));
    this.pathGroup.add(path.mesh);
    this.paths.set(id, path);
    return path;
  }

  private remove(id: number): void {
    const path = this.paths.get(id);
    if (path) this.pathGroup.remove(path.mesh);
    path?.dispose();
    this.paths.delete(id);
    for (const key of this.scanned.get(id) ?? []) {
      this.cloud.remove(key);
      this.rays.remove(key);
    }
    this.scanned.delete(id);
  }
}

/** Returns the place on the floor under a robot. */
function footOf({ pose }: RobotState, { wheels, wheel_radius }: RobotClass): [number, number, number] {
  const [x, y, z] = pose;
  const lowest = Math.max(0, ...wheels.filter(({ link }) => link === null).map(({ position }) => position[2]));
  const below = wheels.length > 0 ? lowest + wheel_radius - PATH_HEIGHT : 0;
  const down = new THREE.Vector3(0, 0, below).applyQuaternion(new THREE.Quaternion(pose[3], pose[4], pose[5], pose[6]));
  return [x + down.x, y + down.y, z + down.z];
}

/** Returns the half axes of a tyre's patch, along and across, at a contact. */
function patchAxes(
  { link, position }: Wheel,
  [length, width]: [number, number],
  at: THREE.Vector3,
  robot: RobotState,
): [THREE.Vector3, THREE.Vector3] {
  const hub = mountOf({ link, pose: [...position, 0, 0, 0, 1] }, robot);
  const across = new THREE.Vector3().setFromMatrixColumn(hub, 1);
  const down = at.clone().sub(new THREE.Vector3().setFromMatrixPosition(hub));
  const along = down.cross(across).normalize();
  return [along.multiplyScalar(length), across.multiplyScalar(width)];
}

/** Returns the ends of a sensor's beams in the world. */
function beamEnds({ fan, max_range }: Sensor, ranges: number[], mount: THREE.Matrix4): Float32Array {
  // From the right to the left; z is down, so the right is positive.
  const axis = new THREE.Vector3(0, fan && !fan.level ? 1 : 0, fan && !fan.level ? 0 : 1);
  const ends = new Float32Array(3 * ranges.length);
  const end = new THREE.Vector3();
  ranges.forEach((part, beam) => {
    const angle = fan ? beamAngle(fan, beam) : 0;
    end
      .set(part * (max_range ?? 0), 0, 0)
      .applyAxisAngle(axis, angle)
      .applyMatrix4(mount);
    end.toArray(ends, 3 * beam);
  });
  return ends;
}

/** Returns the angle of a beam, rad, positive to the right: they go from the right to the left. */
export function beamAngle({ first, resolution }: NonNullable<Sensor['fan']>, beam: number): number {
  return first - beam * resolution;
}

/** Returns the pose of a sensor in the world. */
export function mountOf({ link, pose }: Pick<Sensor, 'link' | 'pose'>, robot: RobotState): THREE.Matrix4 {
  const mount = setPose(new THREE.Matrix4(), pose);
  const carrier = link === null ? undefined : robot.links[link];
  if (carrier) mount.premultiply(setPose(new THREE.Matrix4(), carrier));
  return mount.premultiply(setPose(new THREE.Matrix4(), robot.pose));
}
