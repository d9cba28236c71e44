/** All robots of one class, drawn together: one instanced mesh for bodies, one for hubs, one for rollers. */

import * as THREE from 'three';
import type { RobotState } from '../protocol/frame';
import type { Colour, Drawn, RobotClass } from '../protocol/scene';
import { coloured, merged, solidGeometry } from './solid';
import { setPose } from './pose';

/** Around a roller and a wheel. */
const SEGMENTS = 10;
/** A roller's stripe, by which one sees it turn. */
const STRIPE: Colour = [0.62, 0.62, 0.64];

export class RobotFleet {
  readonly group = new THREE.Group();
  private readonly parts: { body: Instances; links: Instances[]; wheels: Instances[]; rollers: (Instances | null)[] };
  private readonly poses: THREE.Matrix4[][];

  constructor(readonly robotClass: RobotClass) {
    const { drawn, links, wheels } = robotClass;
    const geometry = ({ shape, pose, colour }: Drawn) => solidGeometry(shape, pose, colour);
    this.parts = {
      body: new Instances(this.group, drawn.map(geometry)),
      links: links.map((link) => new Instances(this.group, link.drawn.map(geometry))),
      wheels: wheels.map((wheel) => new Instances(this.group, wheel.drawn.map(spoked))),
      rollers: wheels.map(({ rollers }) =>
        rollers ? new Instances(this.group, [roller(rollers.outline, rollers.colour)]) : null,
      ),
    };
    this.poses = wheels.map(({ rollers }) => (rollers?.poses ?? []).map((pose) => setPose(new THREE.Matrix4(), pose)));
  }

  /** Puts every robot of the class where it is. */
  place(robots: RobotState[]): void {
    const { body, links, wheels, rollers } = this.parts;
    body.begin(robots.length);
    links.forEach((link) => link.begin(robots.length));
    wheels.forEach((wheel) => wheel.begin(robots.length));
    rollers.forEach((roller, index) => roller?.begin(robots.length * (this.poses[index]?.length ?? 0)));
    const [robot, wheel, local] = [new THREE.Matrix4(), new THREE.Matrix4(), new THREE.Matrix4()];
    for (const state of robots) {
      body.add(setPose(robot, state.pose));
      links.forEach((link, index) => {
        const pose = state.links[index];
        if (pose) link.add(setPose(local, pose).premultiply(robot));
      });
      this.robotClass.wheels.forEach(({ link, position }, index) => {
        const { angle = 0, rollers: angles = [] } = state.wheels[index] ?? {};
        const carrier = link === null ? undefined : state.links[link];
        wheel.copy(robot);
        if (carrier) wheel.multiply(setPose(local, carrier));
        wheel.multiply(local.makeTranslation(...position)).multiply(local.makeRotationY(-angle));
        wheels[index]?.add(wheel);
        this.poses[index]?.forEach((pose, number) => {
          local.makeRotationX(angles[number] ?? 0);
          rollers[index]?.add(local.premultiply(pose).premultiply(wheel));
        });
      });
    }
    body.end();
    links.forEach((link) => link.end());
    wheels.forEach((wheel) => wheel.end());
    rollers.forEach((roller) => roller?.end());
  }

  /** The number in the list last placed of what a ray hits. */
  robotAt(hit: THREE.Intersection): number | null {
    const { body, links, wheels, rollers } = this.parts;
    const instance = hit.instanceId ?? 0;
    if ([body, ...links, ...wheels].some((part) => part.mesh === hit.object)) return instance;
    const index = rollers.findIndex((roller) => roller?.mesh === hit.object);
    return index < 0 ? null : Math.floor(instance / (this.poses[index]?.length ?? 1));
  }

  dispose(): void {
    const { body, links, wheels, rollers } = this.parts;
    [body, ...links, ...wheels, ...rollers].forEach((part) => part?.dispose());
  }
}

/** An instanced mesh that grows. */
class Instances {
  mesh: THREE.InstancedMesh;
  private count = 0;

  constructor(
    private readonly parent: THREE.Group,
    geometries: THREE.BufferGeometry[],
  ) {
    const material = new THREE.MeshLambertMaterial({ vertexColors: true });
    this.mesh = this.make(merged(geometries), material, 1);
  }

  begin(count: number): void {
    if (count > this.mesh.instanceMatrix.count) {
      const { geometry, material } = this.mesh;
      this.parent.remove(this.mesh);
      this.mesh.dispose();
      this.mesh = this.make(geometry, material as THREE.Material, 2 * count);
    }
    this.count = 0;
  }

  add(matrix: THREE.Matrix4): void {
    this.mesh.setMatrixAt(this.count++, matrix);
  }

  end(): void {
    this.mesh.count = this.count;
    this.mesh.instanceMatrix.needsUpdate = true;
    this.mesh.boundingSphere = null;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    (this.mesh.material as THREE.Material).dispose();
    this.mesh.dispose();
  }

  private make(geometry: THREE.BufferGeometry, material: THREE.Material, capacity: number): THREE.InstancedMesh {
    const mesh = new THREE.InstancedMesh(geometry, material, capacity);
    mesh.count = 0;
    // The robots are nearly always in sight, and a bounding sphere of all of them would have to be made each frame.
    mesh.frustumCulled = false;
    mesh.castShadow = mesh.receiveShadow = true;
    this.parent.add(mesh);
    return mesh;
  }
}

/** A piece of a wheel, which turns about y, with a lighter sector by which one sees it turn. */
function spoked({ shape, pose, colour }: Drawn): THREE.BufferGeometry {
  const lighter: Colour = [0, 1, 2].map((part) => Math.min(1, (colour[part] ?? 0) + 0.3)) as Colour;
  const isSector = (x: number, z: number) => Math.abs(Math.atan2(z, x)) < 0.3;
  return solidGeometry(shape, pose, (x, _, z) => (isSector(x, z) ? lighter : colour));
}

/** A roller's exact outline turned about its x axis. */
function roller(outline: [number, number][], colour: Colour): THREE.BufferGeometry {
  const points = outline.map(([along, radius]) => new THREE.Vector2(radius, along));
  const [first, last] = [outline[0] ?? [0, 0], outline[outline.length - 1] ?? [0, 0]];
  points.unshift(new THREE.Vector2(0, first[0]));
  points.push(new THREE.Vector2(0, last[0]));
  // The lathe turns about y.
  const geometry = new THREE.LatheGeometry(points, SEGMENTS).rotateZ(-Math.PI / 2);
  return coloured(geometry, (_, y, z) => (Math.abs(Math.atan2(z, y)) < 0.35 ? STRIPE : colour));
}
