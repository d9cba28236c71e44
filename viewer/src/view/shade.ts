/** Shadow of what never moves on the floor, drawn once: for rungs without a shadow map. */

import * as THREE from 'three';
import { lyingMaterial } from './floor';
import { LIGHT_FROM } from './lights';

/** Pixels of the longer edge of the picture, and of a metre at most. */
const PIXELS = 1024;
const FINEST = 64;
/** Room around the map into which shadows fall, m. */
const ROOM = 2;
/** Height below which nothing casts a shadow, m: the floor itself, and carpets. */
const LOW = 0.01;
/** Height above the floor, m. */
const HEIGHT = 0.002;

/** Everything is laid on the floor along the light. */
const CAST_VERTEX = `
  uniform vec3 from;
  uniform vec2 middle;
  uniform vec2 extent;
  varying float above;
  void main() {
    vec4 place = modelMatrix * vec4(position, 1.0);
    above = place.z;
    vec2 at = place.xy - from.xy * (max(place.z, 0.0) / from.z);
    gl_Position = vec4((at - middle) / extent, 0.0, 1.0);
  }`;
const CAST_FRAGMENT = `
  varying float above;
  void main() {
    if (above < ${LOW}) discard;
    gl_FragColor = vec4(1.0);
  }`;
const VERTEX = `
  varying vec2 at;
  void main() {
    at = uv;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;
const FRAGMENT = `
  uniform sampler2D shadow;
  varying vec2 at;
  void main() {
    // A rougher level of the picture is a softer shadow.
    float alpha = 0.3 * texture2D(shadow, at, 1.2).r;
    if (alpha < 0.004) discard;
    gl_FragColor = vec4(0.0, 0.0, 0.0, alpha);
  }`;

export class Shade {
  readonly mesh: THREE.Mesh;
  private readonly target = new THREE.WebGLRenderTarget(1, 1, {
    depthBuffer: false,
    generateMipmaps: true,
    minFilter: THREE.LinearMipmapLinearFilter,
  });
  private readonly cast = new THREE.ShaderMaterial({
    vertexShader: CAST_VERTEX,
    fragmentShader: CAST_FRAGMENT,
    uniforms: {
      from: { value: LIGHT_FROM },
      middle: { value: new THREE.Vector2() },
      extent: { value: new THREE.Vector2() },
    },
    side: THREE.DoubleSide,
    depthTest: false,
  });

  constructor() {
    const material = lyingMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { shadow: { value: this.target.texture } },
      // Nearer than the floor by little: the foot of a ramp is in front.
      polygonOffsetFactor: 1,
      polygonOffsetUnits: -2,
    });
    this.mesh = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), material);
    this.mesh.position.z = HEIGHT;
    // Under the grid and what lies on the floor.
    this.mesh.renderOrder = 1.5;
  }

  /** Draws the shadow of what stands in a box of the stage. */
  draw(renderer: THREE.WebGLRenderer, still: THREE.Object3D, box: THREE.Box3): void {
    const [middle, size] = [box.getCenter(new THREE.Vector3()), box.getSize(new THREE.Vector3()).addScalar(2 * ROOM)];
    const scale = Math.min(FINEST, PIXELS / Math.max(size.x, size.y));
    this.target.setSize(Math.ceil(size.x * scale), Math.ceil(size.y * scale));
    this.cast.uniforms.middle?.value.set(middle.x, middle.y);
    this.cast.uniforms.extent?.value.set(size.x / 2, size.y / 2);
    this.mesh.position.set(middle.x, middle.y, HEIGHT);
    this.mesh.scale.set(size.x, size.y, 1);
    // The renderer updates what is below it alone.
    still.updateWorldMatrix(true, false);
    const dressed: [THREE.Mesh, THREE.Material | THREE.Material[]][] = [];
    still.traverse((object) => object instanceof THREE.Mesh && dressed.push([object, object.material]));
    const [colour, alpha] = [renderer.getClearColor(new THREE.Color()), renderer.getClearAlpha()];
    for (const [mesh] of dressed) Object.assign(mesh, { material: this.cast, frustumCulled: false });
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(0x000000, 0);
    renderer.clear();
    renderer.render(still, new THREE.Camera());
    renderer.setRenderTarget(null);
    renderer.setClearColor(colour, alpha);
    for (const [mesh, material] of dressed) Object.assign(mesh, { material, frustumCulled: true });
  }
}
