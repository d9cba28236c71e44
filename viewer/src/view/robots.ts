/** Robots of the world: their classes' fleets, the rings under them, and the robot that a ray meets. */

import * as THREE from 'three';
import type { Frame, RobotState } from '../protocol/frame';
import type { RobotClass, Scene } from '../protocol/scene';
import { type Decal, Decals } from './decals';
import { setPose } from './pose';
import { type Placed, RobotFleet, type Seen } from './robot';
import type { Surfaces } from './surfaces';

/** Class and name of a robot by its number. */
export type Roster = (robot: number) => { name: string; class: string } | null;

/** Strength of the shadow under a robot, 0 to 1, and of its ring: plain, hovered and selected. */
const SHADOW = 0.5;
const RING = { plain: 0.85, hovered: 1.35, selected: 1.8 };
/** The shadow of what flies fades with its height, m. */
const FADING = 2;
/** Distance from a robot within which a pointer counts as on it, m. */
const GENEROUS = 0.02;

export interface Known {
  state: RobotState;
  name: string;
  colour: string;
  fleet: RobotFleet;
}

/** A robot that a ray meets: its number, the link or null for the body, and the distance, m. */
export interface Met {
  robot: number;
  link: number | null;
  distance: number;
}

export class Robots {
  readonly group = new THREE.Group();
  selected: number | null = null;
  hovered: number | null = null;
  /** Fleets of the classes that have been seen. Building all would delay the first picture. */
  private readonly fleets = new Map<string, RobotFleet>();
  private readonly decals: Decals;
  private known: Known[] = [];

  constructor(
    private readonly scene: Scene,
    private readonly surfaces: Surfaces,
    private readonly roster: Roster,
    private readonly colours: (robot: number) => string,
  ) {
    this.decals = new Decals(this.group);
  }

  get decal(): THREE.Object3D {
    return this.decals.mesh;
  }

  /** Robots whose class is known. */
  get all(): readonly Known[] {
    return this.known;
  }

  /** True if a robot has propellers, which turn while nothing else moves. */
  get spin(): boolean {
    return this.known.some(({ fleet }) => fleet.spins);
  }

  fleet(name: string): RobotFleet | null {
    const known = this.fleets.get(name);
    const robotClass = this.scene.classes[name];
    if (known || !robotClass) return known ?? null;
    const fleet = new RobotFleet(robotClass, this.surfaces);
    this.fleets.set(name, fleet);
    this.group.add(fleet.group);
    return fleet;
  }

  find(id: number | null): Known | null {
    return this.known.find(({ state }) => state.id === id) ?? null;
  }

  classOf(id: number): RobotClass | null {
    return this.scene.classes[this.roster(id)?.class ?? ''] ?? null;
  }

  /** Places the robots of a frame as they are seen. */
  place(frame: Frame, seen: Seen): void {
    this.known = frame.robots.flatMap((state) => {
      const entry = this.roster(state.id);
      const fleet = entry && this.fleet(entry.class);
      if (!fleet) return [];
      return [{ state, name: entry.name || `${entry.class} #${state.id}`, colour: this.colours(state.id), fleet }];
    });
    for (const fleet of this.fleets.values()) {
      const own = this.known.filter((known) => known.fleet === fleet);
      fleet.place(
        own.map(({ state }) => state),
        seen,
        frame.time,
      );
    }
    this.decals.set(this.known.map((known) => this.decalOf(known)));
  }

  /** The first robot that a ray of the world meets, at which link, and how far away. */
  meet(ray: THREE.Ray): Met | null {
    let first: Met | null = null;
    for (const { state, fleet } of this.known) {
      for (const placed of fleet.parts(state, null)) {
        const distance = distanceTo(placed, ray);
        if (distance !== null && distance < (first?.distance ?? Infinity)) {
          first = { robot: state.id, link: placed.link, distance };
        }
      }
    }
    return first;
  }

  dispose(): void {
    this.fleets.forEach((fleet) => fleet.dispose());
    this.decals.dispose();
  }

  private decalOf({ state, colour, fleet }: Known): Decal {
    const { min, max } = fleet.bounds;
    const isSelected = state.id === this.selected;
    const ring = isSelected ? RING.selected : state.id === this.hovered ? RING.hovered : RING.plain;
    const matrix = setPose(new THREE.Matrix4(), state.pose);
    const middle = new THREE.Vector3((min.x + max.x) / 2, (min.y + max.y) / 2, max.z - 0.004);
    const size: [number, number] = [(max.x - min.x) / 2, (max.y - min.y) / 2];
    let shadow = SHADOW;
    if (fleet.robotClass.steering === 'Aerial') {
      // On the floor below, where z is 0.
      const height = Math.max(0, -state.pose[2] - max.z);
      shadow *= Math.max(0, 1 - height / FADING);
      const yaw = new THREE.Euler().setFromRotationMatrix(matrix, 'ZYX').z;
      matrix.makeRotationZ(yaw).setPosition(state.pose[0], state.pose[1], -max.z);
    }
    return {
      matrix: matrix.multiply(new THREE.Matrix4().makeTranslation(middle)),
      size,
      shadow,
      colour: new THREE.Color(colour),
      ring,
    };
  }
}

/** Along a ray of the world to the box about a part. */
function distanceTo({ part, matrix }: Placed, ray: THREE.Ray): number | null {
  const box = part.mesh.geometry.boundingBox;
  if (!box) return null;
  const own = ray.clone().applyMatrix4(matrix.clone().invert());
  const hit = own.intersectBox(box.clone().expandByScalar(GENEROUS), new THREE.Vector3());
  return hit ? hit.distanceTo(own.origin) : null;
}
