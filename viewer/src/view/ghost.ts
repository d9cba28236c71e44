/** A robot that is not there: where one would be put, or where another run was. */

import * as THREE from 'three';
import type { RobotState } from '../protocol/frame';
import type { Pose, Vector } from '../protocol/scene';
import { Decals } from './decals';
import type { RobotFleet } from './robot';

/** Opacity of the robot, 0 to 1. */
const STRENGTH = 0.55;
/** Colour where the robot cannot stand. */
const REFUSED = '#e01b24';

export class Ghost {
  readonly group = new THREE.Group();
  private readonly material = new THREE.MeshLambertMaterial({
    vertexColors: true,
    transparent: true,
    opacity: STRENGTH,
  });
  private readonly decals = new Decals(this.group);
  private shown: RobotFleet | null = null;
  private readonly robot = new THREE.Group();
  private fits = true;

  constructor() {
    this.group.add(this.robot);
    this.group.visible = false;
  }

  get decal(): THREE.Object3D {
    return this.decals.mesh;
  }

  /** Turns red where the robot cannot stand. */
  setFits(fits: boolean): void {
    this.fits = fits;
    this.material.color.set(fits ? '#ffffff' : REFUSED);
    this.material.emissive.set(fits ? '#000000' : REFUSED);
    this.material.opacity = fits ? STRENGTH : 0.75;
  }

  /** A robot of a fleet's class on a place of the ground; links stand as those of another robot of the class. */
  show(fleet: RobotFleet | null, place: Vector, yaw: number, alike: RobotState | null, colour: string): void {
    this.group.visible = fleet !== null;
    if (!fleet) return;
    if (fleet !== this.shown) this.build(fleet, alike);
    const { min, max } = fleet.bounds;
    const [x, y, z] = place;
    this.robot.position.set(x, y, z - max.z);
    this.robot.rotation.z = yaw;
    const middle = new THREE.Vector3((min.x + max.x) / 2, (min.y + max.y) / 2, 0);
    const matrix = new THREE.Matrix4().makeRotationZ(yaw).setPosition(x, y, z - 0.004);
    this.decals.set([
      {
        matrix: matrix.multiply(new THREE.Matrix4().makeTranslation(middle)),
        size: [(max.x - min.x) / 2, (max.y - min.y) / 2],
        shadow: 0.25,
        colour: new THREE.Color(this.fits ? colour : REFUSED),
        ring: 1.4,
      },
    ]);
  }

  /** Shows a robot of a fleet's class at a pose, without a shadow; none hides it. */
  put(fleet: RobotFleet | null, [x, y, z, ...turn]: Pose): void {
    this.group.visible = fleet !== null;
    if (!fleet) return;
    if (fleet !== this.shown) this.build(fleet, null);
    this.robot.position.set(x, y, z);
    this.robot.quaternion.set(...turn);
  }

  /** Forgets the classes of a world that is no more. */
  clear(): void {
    this.shown = null;
    this.robot.clear();
    this.group.visible = false;
  }

  private build(fleet: RobotFleet, alike: RobotState | null): void {
    this.shown = fleet;
    this.robot.clear();
    const pose: Pose = [0, 0, 0, 0, 0, 0, 1];
    const still = { pose, wheels: [], links: alike?.links ?? [], contacts: [] } as unknown as RobotState;
    // Near enough for the rollers to be exact.
    for (const { part, matrix } of fleet.parts(still, { eye: new THREE.Vector3(), sharpness: 1 })) {
      const mesh = new THREE.Mesh(part.mesh.geometry, this.material);
      matrix.decompose(mesh.position, mesh.quaternion, mesh.scale);
      mesh.castShadow = false;
      mesh.renderOrder = 5;
      this.robot.add(mesh);
    }
  }
}
