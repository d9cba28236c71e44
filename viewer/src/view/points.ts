/** Ends of the beams of all lasers as one cloud of points, larger when near. */

import * as THREE from 'three';

/** Diameter of a point, m, and its bounds on the screen, px. */
const SIZE = 0.035;
const BOUNDS = [1.8, 9] as const;

const VERTEX = `
  attribute vec3 tint;
  varying vec3 colour;
  uniform float pixelsPerMetre;
  uniform float ratio;
  void main() {
    colour = tint;
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * place;
    gl_PointSize = ratio * clamp(${SIZE} * pixelsPerMetre / -place.z, ${BOUNDS[0].toFixed(1)}, ${BOUNDS[1].toFixed(1)});
    // In front of the wall that it lies on.
    gl_Position.z -= 0.0006 * gl_Position.w;
  }`;
const FRAGMENT = `
  varying vec3 colour;
  void main() {
    vec2 at = gl_PointCoord - 0.5;
    if (dot(at, at) > 0.25) discard;
    gl_FragColor = vec4(colour, 1.0);
    #include <colorspace_fragment>
  }`;

export class PointCloud {
  readonly points: THREE.Points;
  readonly uniforms = { pixelsPerMetre: { value: 800 }, ratio: { value: 1 } };
  private readonly parts = new Map<string, { places: Float32Array; colour: THREE.Color }>();
  private stale = false;

  constructor() {
    const material = new THREE.ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: this.uniforms,
      // Drawn after the floor.
      transparent: true,
      depthWrite: false,
    });
    this.points = new THREE.Points(new THREE.BufferGeometry(), material);
    this.points.frustumCulled = false;
    this.points.renderOrder = 6;
  }

  set(key: string, places: Float32Array, colour: THREE.Color): void {
    this.parts.set(key, { places, colour });
    this.stale = true;
  }

  remove(key: string): void {
    this.stale = this.parts.delete(key) || this.stale;
  }

  /** Gives what has changed to the card. */
  update(): void {
    if (!this.stale) return;
    this.stale = false;
    const count = [...this.parts.values()].reduce((sum, { places }) => sum + places.length, 0);
    const { geometry } = this.points;
    if ((geometry.getAttribute('position')?.array.length ?? 0) < count) {
      geometry.dispose();
      for (const name of ['position', 'tint']) {
        geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(2 * count + 3), 3));
      }
    }
    const [position, tint] = [geometry.getAttribute('position'), geometry.getAttribute('tint')];
    if (!position || !tint) return;
    let at = 0;
    for (const { places, colour } of this.parts.values()) {
      (position.array as Float32Array).set(places, at);
      for (let end = at + places.length; at < end; at += 3) colour.toArray(tint.array as Float32Array, at);
    }
    position.needsUpdate = tint.needsUpdate = true;
    geometry.setDrawRange(0, count / 3);
  }

  dispose(): void {
    this.points.geometry.dispose();
    (this.points.material as THREE.Material).dispose();
  }
}
