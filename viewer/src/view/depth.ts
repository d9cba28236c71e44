/** Depth as colours: everything is drawn by its distance from the camera, near things red, far ones violet. */

import * as THREE from 'three';

/** Least distances between which colours differ, m. */
const LEAST = [0.3, 8] as const;
/** Parts of the camera's distance from what it looks at, within which colours differ. */
const PARTS = [0.4, 2.5] as const;
/** Colours at equal steps from near to far. */
export const DEPTH_COLOURS = ['#b3161b', '#ee7d2b', '#f4dd4b', '#5cc46a', '#2c8fc4', '#3c3f9e', '#1d1238'] as const;

const VERTEX = `
  varying float away;
  void main() {
    #include <begin_vertex>
    #include <project_vertex>
    away = -mvPosition.z;
  }`;
const FRAGMENT = `
  varying float away;
  uniform vec2 range;
  uniform vec3 colours[${DEPTH_COLOURS.length}];
  void main() {
    float part = log(away / range.x) / log(range.y / range.x);
    float place = clamp(part, 0.0, 1.0) * ${(DEPTH_COLOURS.length - 1).toFixed(1)};
    vec3 colour = colours[0];
    for (int at = 0; at < ${DEPTH_COLOURS.length - 1}; at++)
      colour = mix(colour, colours[at + 1], clamp(place - float(at), 0.0, 1.0));
    gl_FragColor = vec4(colour, 1.0);
    #include <colorspace_fragment>
  }`;

/** Returns the distances between which colours differ, m, for a camera that is so far from what it looks at. They change with the logarithm. */
export function depthRange(distance: number): [number, number] {
  return [Math.max(LEAST[0], PARTS[0] * distance), Math.max(LEAST[1], PARTS[1] * distance)];
}

export function depthMaterial(): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: {
      range: { value: new THREE.Vector2() },
      colours: { value: DEPTH_COLOURS.map((colour) => new THREE.Color(colour)) },
    },
    side: THREE.DoubleSide,
  });
}
