/** Map: solids, movable objects and starts. */

import * as THREE from 'three';
import { startsOf } from '../offer';
import type { ObjectState } from '../protocol/frame';
import type { Pose, Scene, Solid } from '../protocol/scene';
import { type Decal, Decals } from './decals';
import { drawnSolid, edgesOf } from './look';
import type { Outlined } from './outline';
import { moveTo, setPose } from './pose';
import { merged, ownBounds, shapeGeometry } from './solid';
import { type SurfaceName, type Surfaces, surfaceOf } from './surfaces';

const IDENTITY: Pose = [0, 0, 0, 0, 0, 0, 1];
/** Lines along the edges of solids. */
const EDGE = { color: 0x20242b, opacity: 0.38 };
/** The colour of starts. */
const START = 0x4a86c8;
/** A solid that begins higher above what it stands on casts no contact shadow, m. */
const TOUCHING = 0.03;
/** Cosine of the angle up to which a thing is upright. */
const UPRIGHT = 0.98;
/** Half the edge of the largest mesh that has a contact shadow, m. */
const LARGEST_MESH = 1.5;

/** Lookup of a movable object by number; null while it is unknown. */
export type Catalogue = (number: number) => Solid | null;

/** The map's objects where it has them. */
export function objectsOf({ map }: Scene): ObjectState[] {
  return map.objects.map(({ pose }, number) => ({ number, pose }));
}

export class MapView {
  readonly group = new THREE.Group();
  /** Meshes on which a robot can be put. */
  readonly ground = new THREE.Group();
  readonly starts = new THREE.Group();
  /** Planes without an end. */
  private readonly floors: THREE.Mesh[] = [];
  /** Bounding box of the finite parts, on the stage; empty if there are none. */
  readonly bounds = new THREE.Box3();
  /** Shown objects by number. */
  private readonly objects = new Map<number, { solid: Solid; mesh: THREE.Mesh }>();
  private readonly tops: Top[];
  private readonly standing: Decals;
  private readonly moving: Decals;
  private readonly edges = new THREE.LineBasicMaterial({ ...EDGE, transparent: true, depthWrite: false });

  constructor(
    private readonly scene: Scene,
    private readonly surfaces: Surfaces,
    private readonly catalogue: Catalogue,
  ) {
    const { solids, markings } = scene.map;
    const kinds = new Map<string, { kind: SurfaceName; isFloor: boolean; geometries: THREE.BufferGeometry[] }>();
    [...solids, ...markings].forEach((solid, index) => {
      const kind = index < solids.length ? surfaceOf(solid.material) : 'marking';
      const isFloor = solid.shape === 'HalfSpace';
      const known = kinds.get(`${kind} ${isFloor}`) ?? { kind, isFloor, geometries: [] };
      known.geometries.push(drawnSolid(solid, solid.pose, index));
      kinds.set(`${kind} ${isFloor}`, known);
    });
    for (const { kind, isFloor, geometries } of kinds.values()) {
      const mesh = this.mesh(merged(geometries), kind);
      this.ground.add(mesh);
      if (isFloor) this.floors.push(mesh);
    }
    const edges = this.lines(solids.flatMap((solid) => edgesOf(solid, solid.pose)));
    for (const { position, rotation } of startsOf(scene)) this.starts.add(startMark(position, rotation[2]));
    this.group.add(this.ground, edges, this.starts);
    this.tops = topsOf(solids);
    this.standing = new Decals(this.group);
    this.standing.set(solids.flatMap((solid) => contactShadow(solid, solid.pose, this.tops) ?? []));
    this.moving = new Decals(this.group);
    this.place(objectsOf(scene));
    this.measure();
  }

  /** True if it stands on a plane without an end at a height of 0. */
  get hasFloor(): boolean {
    return this.scene.map.solids.some(({ shape, pose }) => shape === 'HalfSpace' && Math.abs(pose[2]) < 1e-6);
  }

  /** Shows planes without an end and what is painted on them, or neither. */
  showFloor(shown: boolean): void {
    [...this.floors, ...this.decals, this.starts].forEach((object) => (object.visible = shown));
  }

  /** Decals on the floor. */
  get decals(): THREE.Object3D[] {
    return [this.standing.mesh, this.moving.mesh];
  }

  /** Shows the objects that are there and known, and no others. */
  place(objects: ObjectState[]): void {
    const known = objects.flatMap(({ number, pose }) => {
      const solid = this.catalogue(number);
      return solid ? [{ number, pose, solid }] : [];
    });
    const numbers = new Set(known.map(({ number }) => number));
    for (const number of this.objects.keys()) if (!numbers.has(number)) this.remove(number);
    for (const { number, pose, solid } of known) moveTo(this.objectMesh(number, solid), pose);
    this.moving.set(known.flatMap(({ solid, pose }) => contactShadow(solid, pose, this.tops) ?? []));
  }

  /** Returns the object that a ray of the screen meets first, and how far away. */
  meet(ray: THREE.Raycaster): { object: number; distance: number } | null {
    let first: { object: number; distance: number } | null = null;
    for (const [object, { mesh }] of this.objects) {
      const distance = ray.intersectObject(mesh, false)[0]?.distance;
      if (distance !== undefined && distance < (first?.distance ?? Infinity)) first = { object, distance };
    }
    return first;
  }

  /** Returns what an object's outline goes about: nothing if it is not there. */
  outlined(number: number | null): Outlined[] {
    const shown = number === null ? undefined : this.objects.get(number);
    if (!shown) return [];
    shown.mesh.updateMatrix();
    return [{ part: shown, matrix: shown.mesh.matrix }];
  }

  dispose(): void {
    this.standing.dispose();
    this.moving.dispose();
    this.edges.dispose();
    disposeGeometries(this.group);
    this.starts.traverse((object) => object instanceof THREE.Mesh && (object.material as THREE.Material).dispose());
  }

  /** An object as it is shown; anew if it is another than before. */
  private objectMesh(number: number, solid: Solid): THREE.Mesh {
    const shown = this.objects.get(number);
    if (shown?.solid === solid) return shown.mesh;
    this.remove(number);
    const mesh = this.mesh(drawnSolid(solid, IDENTITY, number), surfaceOf(solid.material));
    mesh.add(this.lines(edgesOf(solid, IDENTITY)));
    this.group.add(mesh);
    this.objects.set(number, { solid, mesh });
    return mesh;
  }

  private remove(number: number): void {
    const shown = this.objects.get(number);
    if (!shown) return;
    this.group.remove(shown.mesh);
    disposeGeometries(shown.mesh);
    this.objects.delete(number);
  }

  private mesh(geometry: THREE.BufferGeometry, kind: SurfaceName): THREE.Mesh {
    const mesh = new THREE.Mesh(geometry);
    this.surfaces.cover(mesh, kind);
    mesh.castShadow = mesh.receiveShadow = true;
    return mesh;
  }

  private lines(ends: number[]): THREE.LineSegments {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.Float32BufferAttribute(ends, 3));
    const lines = new THREE.LineSegments(geometry, this.edges);
    lines.renderOrder = 3;
    return lines;
  }

  private measure(): void {
    for (const { shape, pose } of [...this.scene.map.solids, ...this.scene.map.objects]) {
      if (shape !== 'HalfSpace') this.bounds.union(boundsOf(shape, pose));
    }
    for (const { position } of this.scene.map.starts) this.bounds.expandByPoint(new THREE.Vector3(...position));
    // The stage has z up.
    if (!this.bounds.isEmpty()) this.bounds.applyMatrix4(new THREE.Matrix4().makeRotationX(Math.PI));
  }
}

function disposeGeometries(root: THREE.Object3D): void {
  root.traverse((object) => {
    if (object instanceof THREE.Mesh || object instanceof THREE.LineSegments) object.geometry.dispose();
  });
}

function boundsOf(shape: Solid['shape'], pose: Pose): THREE.Box3 {
  const geometry = shapeGeometry(shape).applyMatrix4(setPose(new THREE.Matrix4(), pose));
  geometry.computeBoundingBox();
  return geometry.boundingBox ?? new THREE.Box3();
}

/** Top of a box of the map, on which other things stand. */
interface Top {
  /** Pose of the box, and half its length, breadth and height, m. */
  inverse: THREE.Matrix4;
  half: [number, number];
  /** Height of its top in the wire's frame, m: down is positive. */
  z: number;
}

/** Returns the tops of the boxes that lie level. */
function topsOf(solids: Solid[]): Top[] {
  return solids.flatMap(({ shape, pose }) => {
    if (shape === 'HalfSpace' || !('Box' in shape)) return [];
    const [x, y, z] = shape.Box.size;
    const matrix = setPose(new THREE.Matrix4(), pose);
    if (new THREE.Vector3(0, 0, 1).transformDirection(matrix).z < UPRIGHT) return [];
    return [{ inverse: matrix.invert(), half: [x / 2, y / 2] as [number, number], z: pose[2] - z / 2 }];
  });
}

/** Returns the shadow under what stands upright on the floor, or on a box. */
function contactShadow({ shape }: Solid, pose: Pose, tops: Top[]): Decal | null {
  if (shape === 'HalfSpace' || 'HeightField' in shape) return null;
  const { min, max } = ownBounds(shape);
  const [x, y, z] = [Math.min(-min.x, max.x), Math.min(-min.y, max.y), max.z];
  // A mesh of the size of a room is no thing that stands there.
  if ('Mesh' in shape && Math.max(x, y) > LARGEST_MESH) return null;
  const matrix = setPose(new THREE.Matrix4(), pose);
  const down = new THREE.Vector3(0, 0, 1).transformDirection(matrix);
  if (down.z < UPRIGHT) return null;
  const bottom = pose[2] + z * down.z;
  const holds = ({ inverse, half, z: top }: Top) => {
    const at = new THREE.Vector3(pose[0], pose[1], top).applyMatrix4(inverse);
    return Math.abs(bottom - top) < TOUCHING && Math.abs(at.x) < half[0] && Math.abs(at.y) < half[1];
  };
  const ground = Math.abs(bottom) <= TOUCHING ? 0 : tops.find(holds)?.z;
  if (ground === undefined) return null;
  // What is low keeps less light away.
  const shadow = 0.42 * Math.min(1, (2 * z) / 0.4);
  const round = 'Ball' in shape ? 0.4 : 1;
  return { matrix: matrix.setPosition(pose[0], pose[1], ground - 0.002), size: [round * x, round * y], shadow };
}

/** A quiet arrow where robots start, along their direction. */
function startMark([x, y, z]: [number, number, number], yaw: number): THREE.Object3D {
  const arrow = new THREE.Shape();
  arrow.moveTo(0.24, 0).lineTo(-0.12, 0.12).lineTo(-0.05, 0).lineTo(-0.12, -0.12);
  const material = new THREE.MeshBasicMaterial({
    color: START,
    transparent: true,
    opacity: 0.5,
    side: THREE.DoubleSide,
    depthWrite: false,
  });
  const mesh = new THREE.Mesh(new THREE.ShapeGeometry(arrow), material);
  mesh.position.set(x, y, z - 0.006);
  mesh.rotation.z = yaw;
  mesh.renderOrder = 3;
  return mesh;
}
