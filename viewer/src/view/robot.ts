/** Robots of one class, drawn together: one instanced mesh for each part that looks different. */

import * as THREE from 'three';
import type { RobotState } from '../protocol/frame';
import type { Drawn, RobotClass, Wheel } from '../protocol/scene';
import { Instances } from './instances';
import { setPose } from './pose';
import { simplified } from './simplify';
import { merged, solidGeometry } from './solid';
import type { Surfaces } from './surfaces';
import { pad, padPoses } from './belt';
import { roller, spoked } from './wheel';

/** Distances of the levels of detail, in robots: rollers become one piece with their wheels, and all parts become simple. */
const FAR = 6;
const AFAR = 11;
/** Smallest part drawn at the level `afar`, as a share of the robot. */
const SIMPLE = 1 / 24;

/** Joint compliance under load, m. Parts this far below the ground are raised onto it. */
const GIVING_WAY = 0.012;

/** Levels of detail: without rollers, everything, rollers that do not turn by themselves, or few triangles. */
type Level = 'plain' | 'near' | 'far' | 'afar';

/** A piece that looks the same on every robot, for each level; one that is near has its rollers beside it. */
interface Piece {
  near: Instances;
  far: Instances;
  afar: Instances;
}

interface Rollers {
  one: Instances;
  poses: THREE.Matrix4[];
}

/** The pads of a belt, which move around it. */
interface Belt {
  one: Instances;
  of: NonNullable<Wheel['belt']>;
}

/** A piece that turns about its own z axis with the world's time, as a propeller. */
interface Spinner {
  one: Instances;
  /** Carrier among the links; null for the body. */
  link: number | null;
  pose: THREE.Matrix4;
  /** rad/s */
  speed: number;
}

/** Place in the world from which robots are seen, and the pixels that are drawn for one of the page: with few of them details are lost sooner. */
export interface Seen {
  eye: THREE.Vector3;
  sharpness: number;
}

/** A part of a robot and where it is. */
export interface Placed {
  part: Instances;
  /** Matrix in the world. */
  matrix: THREE.Matrix4;
  /** Index of the link that carries it; null for the body. */
  link: number | null;
}

export class RobotFleet {
  readonly group = new THREE.Group();
  /** Bounding box of the body and its wheels, down to the lowest part, in the robot's frame. */
  readonly bounds = new THREE.Box3();
  /** Diagonal of the bounds, m. */
  readonly size: number;
  private readonly body: Piece;
  private readonly links: Piece[];
  /** Rollers of each wheel; wheels that look alike share theirs. A browser without a graphics card takes its time for each instance. */
  private readonly wheels: Piece[];
  private readonly rollers: (Rollers | null)[];
  private readonly belts: (Belt | null)[];
  private readonly spinners: Spinner[];
  private readonly all: Instances[];

  constructor(
    readonly robotClass: RobotClass,
    surfaces: Surfaces,
  ) {
    const { drawn, links, wheels } = robotClass;
    const rigidly = (drawn: Drawn[]) =>
      merged(
        drawn.filter(({ spin }) => spin === 0).map(({ shape, pose, colour }) => solidGeometry(shape, pose, colour)),
      );
    const bodyGeometry = rigidly(drawn);
    const linkGeometries = links.map((link) => rigidly(link.drawn));
    const hubs = wheels.map(
      remembering(
        (wheel) => merged(wheel.drawn.map(spoked)),
        ({ drawn }) => drawn,
      ),
    );
    this.measure(bodyGeometry, hubs, linkGeometries);
    this.size = this.bounds.getSize(new THREE.Vector3()).length();

    const instances = (geometry: THREE.BufferGeometry) => new Instances(this.group, geometry, surfaces);
    const afar = (geometry: THREE.BufferGeometry) => instances(simplified(geometry, SIMPLE * this.size));
    const rigid = (geometry: THREE.BufferGeometry): Piece => {
      const near = instances(geometry);
      return { near, far: near, afar: afar(geometry) };
    };
    const wheelPiece = ({ hub, rollers }: { hub: THREE.BufferGeometry; rollers: Wheel['rollers'] }): Piece => {
      if (!rollers) return rigid(hub);
      const { outline, colour, poses } = rollers;
      const simple = roller(outline, colour, false);
      const turned = poses.map((pose) => simple.clone().applyMatrix4(setPose(new THREE.Matrix4(), pose)));
      const whole = merged([hub, ...turned]);
      return { near: instances(hub), far: instances(whole), afar: afar(whole) };
    };

    this.body = rigid(bodyGeometry);
    this.links = linkGeometries.map(rigid);
    const assembled = hubs.map((hub, index) => ({ hub, rollers: wheels[index]?.rollers ?? null }));
    this.wheels = assembled.map(remembering(wheelPiece, ({ hub, rollers }) => [hub.uuid, rollers]));
    const oneRoller = remembering(
      ({ outline, colour }: NonNullable<Wheel['rollers']>) => instances(roller(outline, colour, true)),
      ({ outline, colour }) => [outline, colour],
    );
    this.rollers = wheels.map(
      ({ rollers }) =>
        rollers && {
          one: oneRoller(rollers),
          poses: rollers.poses.map((pose) => setPose(new THREE.Matrix4(), pose)),
        },
    );
    const onePad = remembering(
      (belt: NonNullable<Wheel['belt']>) => instances(pad(belt)),
      ({ size, colour }) => [size, colour],
    );
    this.belts = wheels.map(({ belt }) => belt && { one: onePad(belt), of: belt });
    const oneSpinner = remembering(
      ({ shape, colour }: Drawn) => instances(solidGeometry(shape, [0, 0, 0, 0, 0, 0, 1], colour)),
      ({ shape, colour }) => [shape, colour],
    );
    const spinner = (link: number | null) => (it: Drawn) => ({
      one: oneSpinner(it),
      link,
      pose: setPose(new THREE.Matrix4(), it.pose),
      speed: it.spin,
    });
    const spinning = (drawn: Drawn[], link: number | null) => drawn.filter(({ spin }) => spin !== 0).map(spinner(link));
    this.spinners = [...spinning(drawn, null), ...links.flatMap((link, index) => spinning(link.drawn, index))];
    const pieces = [this.body, ...this.links, ...this.wheels].flatMap(({ near, far, afar }) => [near, far, afar]);
    const moving = [...this.rollers, ...this.belts, ...this.spinners].flatMap((moving) => moving?.one ?? []);
    this.all = [...new Set([...pieces, ...moving])];
    this.all.forEach(({ mesh: { geometry } }) => geometry.hasAttribute('position') && geometry.computeBoundingBox());
  }

  /** True if it has pieces that turn with the world's time. */
  get spins(): boolean {
    return this.spinners.length > 0;
  }

  /** Puts every robot of the class where it is at a time, s, as it is seen. */
  place(robots: RobotState[], seen: Seen, time: number): void {
    this.all.forEach((part) => part.begin());
    for (const robot of robots) {
      this.parts(robot, seen, time).forEach(({ part, matrix }) => part.add(matrix));
    }
    this.all.forEach((part) => part.end());
  }

  /** The parts of a robot as it is seen; near, and without its rollers, if nobody sees it. */
  parts(state: RobotState, seen: Seen | null, time = 0): Placed[] {
    const level = this.level(state, seen);
    const detail = level === 'plain' ? 'near' : level;
    const robot = setPose(new THREE.Matrix4(), state.pose);
    const placed: Placed[] = [{ part: this.body[detail], matrix: robot, link: null }];
    const carriers = this.links.map((link, index) => {
      const pose = state.links[index];
      const matrix = pose ? setPose(new THREE.Matrix4(), pose).premultiply(robot) : null;
      if (matrix) placed.push({ part: link[detail], matrix, link: index });
      return matrix;
    });
    this.spinners.forEach(({ one, link, pose, speed }) => {
      const carrier = link === null ? robot : carriers[link];
      const turn = new THREE.Matrix4().makeRotationZ(speed * time).premultiply(pose);
      if (carrier) placed.push({ part: one, matrix: turn.premultiply(carrier), link });
    });
    const local = new THREE.Matrix4();
    this.robotClass.wheels.forEach(({ link, position }, index) => {
      const { angle = 0, rollers: angles = [] } = state.wheels[index] ?? {};
      const wheel = ((link !== null && carriers[link]) || robot).clone();
      const belt = this.belts[index];
      wheel.multiply(local.makeTranslation(...position));
      if (!belt) wheel.multiply(local.makeRotationY(-angle));
      const piece = this.wheels[index];
      if (piece) placed.push({ part: piece[detail], matrix: wheel, link });
      if (belt) {
        for (const matrix of padPoses(belt.of, angle))
          placed.push({ part: belt.one, matrix: matrix.premultiply(wheel), link });
      }
      const rollers = level === 'near' ? this.rollers[index] : null;
      rollers?.poses.forEach((pose, number) => {
        const matrix = new THREE.Matrix4().makeRotationX(angles[number] ?? 0);
        placed.push({ part: rollers.one, matrix: matrix.premultiply(pose).premultiply(wheel), link });
      });
    });
    return placed;
  }

  /** Height of a robot above its own place, m. */
  height(state: RobotState): number {
    let top = 0;
    const box = new THREE.Box3();
    for (const { part, matrix } of this.parts(state, null)) {
      const own = part.mesh.geometry.boundingBox;
      if (own) top = Math.max(top, state.pose[2] - box.copy(own).applyMatrix4(matrix).min.z);
    }
    return top;
  }

  dispose(): void {
    this.all.forEach((part) => part.dispose());
  }

  private level({ pose: [x, y, z] }: RobotState, seen: Seen | null): Level {
    if (!seen) return 'plain';
    const { eye, sharpness } = seen;
    const robots = Math.hypot(eye.x - x, eye.y - y, eye.z - z) / this.size / Math.min(1, sharpness);
    return robots < FAR ? 'near' : robots < AFAR ? 'far' : 'afar';
  }

  private measure(body: THREE.BufferGeometry, hubs: THREE.BufferGeometry[], limbs: THREE.BufferGeometry[]): void {
    const add = (geometry: THREE.BufferGeometry | undefined, x: number, y: number, z: number) => {
      if (!geometry?.hasAttribute('position')) return;
      geometry.computeBoundingBox();
      if (geometry.boundingBox) this.bounds.union(geometry.boundingBox.clone().translate(new THREE.Vector3(x, y, z)));
    };
    add(body, 0, 0, 0);
    this.robotClass.wheels.forEach(({ link, position }, index) => {
      if (link !== null) return;
      add(hubs[index], ...position);
      // Its rollers stand out of it.
      const { wheel_radius: radius } = this.robotClass;
      this.bounds.expandByPoint(new THREE.Vector3(position[0], position[1], position[2] + radius));
    });
    // A robot may stand on its links, as on legs or flippers, which give way a little.
    this.robotClass.links.forEach(({ pose }, index) => {
      const limb = limbs[index];
      if (this.bounds.isEmpty() || !limb?.hasAttribute('position')) return;
      limb.computeBoundingBox();
      const box = limb.boundingBox?.clone().applyMatrix4(setPose(new THREE.Matrix4(), pose));
      if (box) this.bounds.max.z = Math.max(this.bounds.max.z, box.max.z - GIVING_WAY);
    });
    if (this.bounds.isEmpty()) this.bounds.set(new THREE.Vector3(-0.2, -0.2, -0.1), new THREE.Vector3(0.2, 0.2, 0.1));
  }
}

/** Makes the same for what looks the same only once. */
function remembering<From, To>(make: (from: From) => To, lookOf: (from: From) => unknown): (from: From) => To {
  const made = new Map<string, To>();
  return (from) => {
    const look = JSON.stringify(lookOf(from));
    const known = made.get(look) ?? make(from);
    made.set(look, known);
    return known;
  };
}
