/** Lines each metre and stronger ones each five, drawn by one shader on one quad that fades with distance. */

import * as THREE from 'three';
import { AXIS_COLOURS } from './colours';
import { lyingMaterial } from './floor';

/** Half the edge of the quad, m. */
const REACH = 200;

const VERTEX = `
  varying vec2 at;
  varying float depth;
  void main() {
    vec4 place = modelMatrix * vec4(position, 1.0);
    at = place.xy;
    vec4 seen = viewMatrix * place;
    depth = -seen.z;
    gl_Position = projectionMatrix * seen;
  }`;

const FRAGMENT = `
  varying vec2 at;
  varying float depth;
  uniform vec3 line;
  uniform vec3 xAxis;
  uniform vec3 yAxis;
  uniform float strength;
  uniform float reach;

  // How much of a pixel a line covers; lines that come too close to each other melt away.
  vec2 covered(vec2 place, vec2 perPixel, float width) {
    vec2 pixels = abs(fract(place - 0.5) - 0.5) / perPixel;
    return clamp(0.5 * width + 0.5 - pixels, 0.0, 1.0) * (1.0 - smoothstep(0.08, 0.3, perPixel));
  }

  void main() {
    float near = 1.0 - smoothstep(0.25 * reach, reach, depth);
    if (near <= 0.0) discard;
    vec2 perPixel = max(fwidth(at), vec2(1e-6));
    vec2 metres = covered(at, perPixel, 1.0);
    vec2 fives = covered(0.2 * at, 0.2 * perPixel, 1.4);
    float all = max(0.6 * max(metres.x, metres.y), max(fives.x, fives.y));
    if (min(perPixel.x, perPixel.y) < 0.004) {
      vec2 fine = covered(10.0 * at, 10.0 * perPixel, 1.0) * (1.0 - smoothstep(0.015, 0.04, 10.0 * perPixel));
      all = max(all, 0.3 * max(fine.x, fine.y));
    }
    vec2 axes = clamp(1.5 - abs(at) / perPixel, 0.0, 1.0);
    // Beside each other's axis: where y is zero runs the x axis.
    vec3 colour = mix(mix(line, xAxis, axes.y), yAxis, axes.x);
    float alpha = near * max(strength * all, 0.55 * max(axes.x, axes.y));
    if (alpha < 0.004) discard;
    gl_FragColor = vec4(colour, alpha);
    #include <colorspace_fragment>
  }`;

export class Grid {
  readonly mesh: THREE.Mesh;
  private readonly uniforms = {
    line: { value: new THREE.Color('#2b3440') },
    xAxis: { value: new THREE.Color(AXIS_COLOURS[0]) },
    yAxis: { value: new THREE.Color(AXIS_COLOURS[1]) },
    strength: { value: 0.2 },
    reach: { value: 60 },
  };

  constructor() {
    const material = lyingMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: this.uniforms });
    this.mesh = new THREE.Mesh(new THREE.PlaneGeometry(2 * REACH, 2 * REACH), material);
    this.mesh.renderOrder = 2;
    this.mesh.frustumCulled = false;
  }

  /** Follows what is looked at from so far away, m. */
  follow({ x, y }: THREE.Vector3, distance: number): void {
    // A little above the floor, from afar a little more.
    this.mesh.position.set(x, y, 0.001 + 0.0003 * distance);
    this.uniforms.reach.value = Math.min(REACH, 25 + 4 * distance);
  }
}
