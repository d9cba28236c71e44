/** Solids as geometries with a colour in each corner, so that many can be one mesh. */

import * as THREE from 'three';
import { mergeGeometries } from 'three/addons/utils/BufferGeometryUtils.js';
import type { Colour, HeightField, Pose, Shape, Vector } from '../protocol/scene';
import { setPose } from './pose';

/** Edge of the square that stands for a plane without end, m: its end is beyond what the air lets through. */
const PLANE_EDGE = 1400;

/** The colour of a corner, by where it is if it depends on that. */
type Colouring = Colour | ((x: number, y: number, z: number) => Colour);

export function solidGeometry(shape: Shape, pose: Pose, colour: Colouring): THREE.BufferGeometry {
  return coloured(shapeGeometry(shape).applyMatrix4(setPose(new THREE.Matrix4(), pose)), colour);
}

const bounds = new WeakMap<object, THREE.Box3>();

/** Returns the box around a shape about its own origin, m. It is found once: meshes have many corners. */
export function ownBounds(shape: Exclude<Shape, 'HalfSpace'>): THREE.Box3 {
  const known = bounds.get(shape);
  if (known) return known;
  const geometry = shapeGeometry(shape);
  geometry.computeBoundingBox();
  geometry.dispose();
  const found = geometry.boundingBox ?? new THREE.Box3();
  bounds.set(shape, found);
  return found;
}

export function shapeGeometry(shape: Shape): THREE.BufferGeometry {
  if (shape === 'HalfSpace') {
    // It is seen from above, which is -z.
    return new THREE.PlaneGeometry(PLANE_EDGE, PLANE_EDGE).rotateX(Math.PI);
  }
  if ('Box' in shape) return new THREE.BoxGeometry(...shape.Box.size);
  if ('Ball' in shape) return new THREE.SphereGeometry(shape.Ball.radius, 24, 16);
  if ('Cylinder' in shape) {
    const { radius, length } = shape.Cylinder;
    return new THREE.CylinderGeometry(radius, radius, length, 32).rotateX(Math.PI / 2);
  }
  if ('Hull' in shape) return boundingBox(shape.Hull.points);
  if ('HeightField' in shape) return ground(shape.HeightField);
  const { vertices, triangles } = shape.Mesh;
  const geometry = new THREE.BufferGeometry();
  const corners = triangles.flatMap((triangle) => triangle.flatMap((corner) => vertices[corner] ?? [0, 0, 0]));
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(corners, 3));
  geometry.computeVertexNormals();
  geometry.setAttribute('uv', new THREE.Float32BufferAttribute(new Float32Array((corners.length / 3) * 2), 2));
  return geometry;
}

/** Heights over a grid, with a smooth look. Cells are divided as the world divides them. */
function ground({ size: [length, width], columns, heights }: HeightField): THREE.BufferGeometry {
  const rows = heights.length / columns;
  const places = heights.flatMap((height, number) => {
    const [row, column] = [Math.floor(number / columns), number % columns];
    return [length * (row / (rows - 1) - 0.5), width * (column / (columns - 1) - 0.5), -height];
  });
  const corners: number[] = [];
  for (let near = 0; near + columns + 1 < heights.length; near++) {
    if (near % columns === columns - 1) continue;
    const [right, far, across] = [near + 1, near + columns, near + columns + 1];
    corners.push(near, right, far, far, right, across);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(places, 3));
  geometry.setAttribute('uv', new THREE.Float32BufferAttribute(new Float32Array(heights.length * 2), 2));
  geometry.setIndex(corners);
  geometry.computeVertexNormals();
  return geometry;
}

function boundingBox(points: Vector[]): THREE.BufferGeometry {
  const box = new THREE.Box3().setFromPoints(points.map((point) => new THREE.Vector3(...point)));
  const [size, middle] = [box.getSize(new THREE.Vector3()), box.getCenter(new THREE.Vector3())];
  return new THREE.BoxGeometry(size.x, size.y, size.z).translate(middle.x, middle.y, middle.z);
}

/** Gives every corner a colour (sRGB). */
export function coloured(geometry: THREE.BufferGeometry, colour: Colouring): THREE.BufferGeometry {
  const places = geometry.getAttribute('position');
  const colours = new Float32Array(places.count * 3);
  const linear = new THREE.Color();
  for (let corner = 0; corner < places.count; corner++) {
    const own =
      typeof colour === 'function' ? colour(places.getX(corner), places.getY(corner), places.getZ(corner)) : colour;
    linear.setRGB(...own, THREE.SRGBColorSpace).toArray(colours, 3 * corner);
  }
  geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
  return geometry;
}

/** Many geometries as one. */
export function merged(geometries: THREE.BufferGeometry[]): THREE.BufferGeometry {
  if (geometries.length === 0) return new THREE.BufferGeometry();
  const [only] = geometries;
  if (only && geometries.length === 1) return only;
  // All of them have an index or none.
  return mergeGeometries(geometries.map((geometry) => (geometry.index ? geometry.toNonIndexed() : geometry)));
}
