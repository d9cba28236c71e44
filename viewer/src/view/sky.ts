/** A dome that goes from the colour of the horizon to that of the zenith; drawn where nothing else is. */

import * as THREE from 'three';
import { LIGHT } from './colours';

const VERTEX = `
  varying vec3 direction;
  void main() {
    direction = position;
    // As far as can be, wherever the camera is.
    gl_Position = (projectionMatrix * vec4(mat3(modelViewMatrix) * position, 1.0)).xyww;
  }`;
const FRAGMENT = `
  varying vec3 direction;
  uniform vec3 horizon;
  uniform vec3 zenith;
  void main() {
    gl_FragColor = vec4(mix(horizon, zenith, smoothstep(0.0, 0.75, normalize(direction).z)), 1.0);
    #include <colorspace_fragment>
  }`;

export class Sky {
  readonly mesh: THREE.Mesh;
  constructor() {
    const material = new THREE.ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: {
        horizon: { value: new THREE.Color(LIGHT.horizon) },
        zenith: { value: new THREE.Color(LIGHT.zenith) },
      },
      side: THREE.BackSide,
      depthWrite: false,
    });
    this.mesh = new THREE.Mesh(new THREE.IcosahedronGeometry(1, 3), material);
    this.mesh.frustumCulled = false;
    // After what is in front of it, so that only what is seen of it costs.
    this.mesh.renderOrder = 1;
  }
}
