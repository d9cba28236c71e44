/** The path of a robot as a band of some pixels. */

import * as THREE from 'three';

/** Places of a path that are kept. */
const PLACES = 3000;
/** The least distance between two places, and how far a piece between two may be from where the robot was, m. */
const STEP = 0.02;
const DEVIATION = 0.004;
/** A robot that has moved farther between two frames was put there, m. */
const JUMP = 0.6;
/** Numbers of a corner: x, y, z and its side, -1 or 1; every place has two corners. */
const CORNER = 4;
const PLACE = 2 * CORNER;

const VERTEX = `
  attribute vec3 before;
  attribute vec4 here;
  attribute vec3 after;
  uniform vec2 screen;
  uniform float breadth;
  void main() {
    mat4 seen = projectionMatrix * modelViewMatrix;
    vec4 from = seen * vec4(before, 1.0);
    vec4 to = seen * vec4(after, 1.0);
    gl_Position = seen * vec4(here.xyz, 1.0);
    vec2 along = (to.xy / max(to.w, 0.01) - from.xy / max(from.w, 0.01)) * screen;
    vec2 aside = length(along) > 1e-4 ? normalize(vec2(-along.y, along.x)) : vec2(0.0);
    gl_Position.xy += here.w * breadth * aside / screen * gl_Position.w;
    // In front of the floor on which it lies.
    gl_Position.z -= 0.0004 * gl_Position.w;
  }`;
const FRAGMENT = `
  uniform vec3 colour;
  void main() {
    gl_FragColor = vec4(colour, 0.9);
    #include <colorspace_fragment>
  }`;

/** Sizes of the picture and of the bands, px. */
export const pathUniforms = { screen: { value: new THREE.Vector2(1, 1) }, breadth: { value: 2 } };

export class Path {
  readonly mesh: THREE.Mesh;
  private readonly buffer = new THREE.InterleavedBuffer(new Float32Array(PLACE * (PLACES + 2)), CORNER);
  private count = 0;
  private readonly last = new THREE.Vector3();
  /** Start of the last piece, and its direction there. */
  private readonly corner = new THREE.Vector3();
  private readonly ahead = new THREE.Vector3();

  constructor(colour: string) {
    const geometry = new THREE.BufferGeometry();
    this.buffer.setUsage(THREE.DynamicDrawUsage);
    // One buffer read at three places: the first and the last place stand in it twice.
    geometry.setAttribute('before', new THREE.InterleavedBufferAttribute(this.buffer, 3, 0));
    geometry.setAttribute('here', new THREE.InterleavedBufferAttribute(this.buffer, 4, PLACE));
    geometry.setAttribute('after', new THREE.InterleavedBufferAttribute(this.buffer, 3, 2 * PLACE));
    geometry.setIndex(indices);
    geometry.setDrawRange(0, 0);
    const material = new THREE.ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { ...pathUniforms, colour: { value: new THREE.Color(colour) } },
      transparent: true,
      depthWrite: false,
      side: THREE.DoubleSide,
    });
    this.mesh = new THREE.Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 4;
  }

  add(x: number, y: number, z: number): void {
    const here = new THREE.Vector3(x, y, z);
    const moved = this.count === 0 ? Infinity : this.last.distanceTo(here);
    if (moved < STEP) return;
    if (moved > JUMP) this.clear();
    if (this.count > 1 && this.continues(here)) this.count -= 1;
    else if (this.count > 0) {
      this.corner.copy(this.last);
      this.ahead.copy(here).sub(this.last).normalize();
    }
    if (this.count === PLACES) {
      // The older half goes.
      this.buffer.array.copyWithin(0, PLACE * (PLACES / 2));
      this.count = PLACES / 2;
      this.buffer.clearUpdateRanges();
    } else this.buffer.addUpdateRange(PLACE * this.count, 3 * PLACE);
    if (this.count === 0) this.put(0, x, y, z);
    this.put(++this.count, x, y, z);
    this.put(this.count + 1, x, y, z);
    this.last.copy(here);
    this.buffer.needsUpdate = true;
    this.mesh.geometry.setDrawRange(0, 6 * Math.max(0, this.count - 1));
  }

  clear(): void {
    this.count = 0;
    this.mesh.geometry.setDrawRange(0, 0);
  }

  dispose(): void {
    // The index belongs to all paths.
    this.mesh.geometry.setIndex(null).dispose();
    (this.mesh.material as THREE.Material).dispose();
  }

  /** True if the last piece can end here instead. The middle of an arc's chord is off by a quarter of its tangent's end. */
  private continues(here: THREE.Vector3): boolean {
    const chord = here.clone().sub(this.corner);
    const aside = chord.clone().cross(this.ahead).length();
    return chord.dot(this.ahead) > 0 && aside < 4 * DEVIATION;
  }

  private put(place: number, ...[x, y, z]: [number, number, number]): void {
    this.buffer.array.set([x, y, z, -1, x, y, z, 1], PLACE * place);
  }
}

/** Two triangles between every two places. */
const indices = new THREE.BufferAttribute(
  new Uint16Array(
    Array.from({ length: PLACES - 1 }, (_, place) => [0, 1, 2, 2, 1, 3].map((corner) => 2 * place + corner)).flat(),
  ),
  1,
);
