/** Rim of the floor: around the map it fades into the sky, so that the world stands there as a model on a table. */

import * as THREE from 'three';
import { LIGHT } from './colours';
import { lyingMaterial } from './floor';

/** Half the edge of what is drawn, m: as far as is seen. */
const REACH = 700;
/** Distance from the map at which the floor begins to fade, and where it is gone: parts of half the map, and m. */
const BEGIN = { part: 0.1, room: 0.5 };
const END = { part: 0.5, room: 3 };
/** Height above the floor, m. */
const HEIGHT = 0.0005;

const VERTEX = `
  varying vec2 at;
  void main() {
    vec4 place = modelMatrix * vec4(position, 1.0);
    at = place.xy;
    gl_Position = projectionMatrix * viewMatrix * place;
  }`;
const FRAGMENT = `
  varying vec2 at;
  uniform vec2 middle;
  uniform vec2 extent;
  uniform vec2 fades;
  uniform vec3 horizon;
  void main() {
    float outside = length(max(abs(at - middle) - extent, 0.0));
    float alpha = smoothstep(fades.x, fades.y, outside);
    if (alpha < 0.004) discard;
    gl_FragColor = vec4(horizon, alpha);
    #include <colorspace_fragment>
  }`;

/** Corners of a square, counterclockwise. */
const CORNERS = [
  [1, 1],
  [-1, 1],
  [-1, -1],
  [1, -1],
] as const;

export class Rim {
  readonly mesh: THREE.Mesh;
  /** Corners of the map, and those of what is seen. */
  private readonly corners = new THREE.BufferAttribute(new Float32Array(3 * 8), 3);
  private readonly uniforms = {
    middle: { value: new THREE.Vector2() },
    extent: { value: new THREE.Vector2() },
    fades: { value: new THREE.Vector2() },
    horizon: { value: new THREE.Color(LIGHT.horizon) },
  };

  constructor() {
    const material = lyingMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: this.uniforms });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', this.corners);
    // Around the map: where nothing fades nothing is drawn.
    geometry.setIndex(
      [0, 1, 2, 3].flatMap((at) => [at, at + 4, ((at + 1) % 4) + 4, at, ((at + 1) % 4) + 4, (at + 1) % 4]),
    );
    this.mesh = new THREE.Mesh(geometry, material);
    this.mesh.position.z = HEIGHT;
    // Over the grid, and under what lies on the floor.
    this.mesh.renderOrder = 2.5;
    this.mesh.frustumCulled = false;
  }

  /** Lets the floor fade around a box of the stage. */
  surround(box: THREE.Box3): void {
    const { middle, extent, fades } = this.uniforms;
    const [centre, size] = [box.getCenter(new THREE.Vector3()), box.getSize(new THREE.Vector3())];
    middle.value.set(centre.x, centre.y);
    extent.value.set(size.x / 2, size.y / 2);
    const half = Math.max(size.x, size.y) / 2;
    fades.value.set(BEGIN.part * half + BEGIN.room, END.part * half + END.room);
    CORNERS.forEach(([x, y], corner) => {
      this.corners.setXYZ(corner, centre.x + (x * size.x) / 2, centre.y + (y * size.y) / 2, 0);
      this.corners.setXYZ(corner + 4, centre.x + x * REACH, centre.y + y * REACH, 0);
    });
    this.corners.needsUpdate = true;
  }
}
