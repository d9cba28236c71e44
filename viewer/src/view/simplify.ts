/** Geometries with fewer triangles, for what is seen from afar. */

import * as THREE from 'three';

/** Corners that share a cell of a lattice become one; triangles that lose a corner go, and of equal ones all but one. */
export function simplified(geometry: THREE.BufferGeometry, cell: number): THREE.BufferGeometry {
  const source = geometry.index ? geometry.toNonIndexed() : geometry;
  const [places, colours] = [source.getAttribute('position'), source.getAttribute('color')];
  if (!places) return geometry;
  const cells = new Map<string, { sum: THREE.Vector3; count: number }>();
  const corner = new THREE.Vector3();
  const keys = Array.from({ length: places.count }, (_, index) => {
    corner.fromBufferAttribute(places, index);
    const key = corner
      .toArray()
      .map((at) => Math.round(at / cell))
      .join();
    const known = cells.get(key) ?? { sum: new THREE.Vector3(), count: 0 };
    known.sum.add(corner);
    known.count += 1;
    cells.set(key, known);
    return key;
  });
  const seen = new Set<string>();
  const [corners, tints]: [number[], number[]] = [[], []];
  for (let first = 0; first < keys.length; first += 3) {
    const triangle = keys.slice(first, first + 3);
    const kind = triangle.toSorted().join(' ');
    if (new Set(triangle).size < 3 || seen.has(kind)) continue;
    seen.add(kind);
    triangle.forEach((key, index) => {
      const { sum, count } = cells.get(key) ?? { sum: corner, count: 1 };
      corners.push(sum.x / count, sum.y / count, sum.z / count);
      tints.push(colours.getX(first + index), colours.getY(first + index), colours.getZ(first + index));
    });
  }
  const result = new THREE.BufferGeometry();
  result.setAttribute('position', new THREE.Float32BufferAttribute(corners, 3));
  result.setAttribute('color', new THREE.Float32BufferAttribute(tints, 3));
  result.setAttribute('uv', new THREE.Float32BufferAttribute(new Float32Array((corners.length / 3) * 2), 2));
  result.computeVertexNormals();
  return result;
}
