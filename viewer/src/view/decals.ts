/** Decals on the floor under things: a contact shadow, and a ring in the colour of a robot. */

import * as THREE from 'three';
import { lyingMaterial } from './floor';

/** Decal of one thing. */
export interface Decal {
  /** Pose of its middle in the parent's frame. */
  matrix: THREE.Matrix4;
  /** Half its length and breadth, m. */
  size: [number, number];
  /** Strength of the shadow, 0 to 1. */
  shadow: number;
  colour?: THREE.Color;
  /** Strength of the ring, 0 to 1; above 1 it is broader. */
  ring?: number;
}

/** Margin around the thing, m. */
const MARGIN = 0.2;
/** Numbers of a decal beside its matrix: size, shadow, ring; colour. */
const NUMBERS = 4;

const VERTEX = `
  attribute vec4 shape;
  attribute vec3 tint;
  varying vec2 at;
  varying vec4 about;
  varying vec3 colour;
  void main() {
    about = shape;
    colour = tint;
    at = position.xy * 2.0 * (shape.xy + ${MARGIN});
    gl_Position = projectionMatrix * modelViewMatrix * instanceMatrix * vec4(at, 0.0, 1.0);
  }`;

const FRAGMENT = `
  varying vec2 at;
  varying vec4 about;
  varying vec3 colour;
  void main() {
    vec2 size = about.xy;
    float corner = min(0.5 * min(size.x, size.y), 0.12);
    vec2 outside = abs(at) - size + corner;
    // From the rim of the thing, m.
    float far = length(max(outside, 0.0)) + min(max(outside.x, outside.y), 0.0) - corner;
    float near = 1.0 - clamp((far + 0.06) / ${MARGIN - 0.01}, 0.0, 1.0);
    float dark = about.z * near * near;
    float ring = 0.0;
    if (about.w > 0.0) {
      float pixel = fwidth(far);
      float breadth = 0.011 * max(1.0, about.w);
      float gap = 0.075;
      ring = 1.0 - smoothstep(breadth - pixel, breadth + pixel, abs(far - gap));
      // A lobe that points ahead.
      vec2 nose = vec2(at.x - size.x - gap - 0.012, abs(at.y));
      float lobe = max(-nose.x, nose.x + nose.y - 0.075);
      ring = max(ring, 1.0 - smoothstep(-pixel, pixel, lobe));
      // Thinner than a pixel it grows fainter.
      ring *= min(1.0, about.w) * clamp(2.5 * breadth / pixel, 0.35, 1.0);
      float glow = max(0.0, about.w - 1.0) * (1.0 - smoothstep(0.0, 0.1, abs(far - gap)));
      // From afar it would outshine a small robot.
      glow *= clamp(0.03 / pixel, 0.0, 1.0);
      ring = max(ring, 0.45 * glow * glow);
    }
    float alpha = max(ring, dark);
    if (alpha < 0.004) discard;
    gl_FragColor = vec4(colour * (ring / alpha), alpha);
    #include <colorspace_fragment>
  }`;

export class Decals {
  mesh: THREE.InstancedMesh;
  private readonly material = lyingMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    side: THREE.DoubleSide,
    polygonOffsetUnits: -4,
  });

  constructor(private readonly parent: THREE.Object3D) {
    this.mesh = this.make(16);
  }

  set(decals: Decal[]): void {
    if (decals.length > this.mesh.instanceMatrix.count) {
      this.drop();
      this.mesh = this.make(2 * decals.length);
    }
    const [shape, tint] = [this.attribute('shape'), this.attribute('tint')];
    decals.forEach(({ matrix, size, shadow, colour, ring = 0 }, index) => {
      this.mesh.setMatrixAt(index, matrix);
      shape.setXYZW(index, ...size, shadow, ring);
      tint.setXYZ(index, colour?.r ?? 0, colour?.g ?? 0, colour?.b ?? 0);
    });
    this.mesh.count = decals.length;
    this.mesh.instanceMatrix.needsUpdate = shape.needsUpdate = tint.needsUpdate = true;
  }

  dispose(): void {
    this.drop();
    this.material.dispose();
  }

  private attribute(name: string): THREE.InstancedBufferAttribute {
    return this.mesh.geometry.getAttribute(name) as THREE.InstancedBufferAttribute;
  }

  private drop(): void {
    this.parent.remove(this.mesh);
    this.mesh.geometry.dispose();
    this.mesh.dispose();
  }

  private make(capacity: number): THREE.InstancedMesh {
    const geometry = new THREE.PlaneGeometry(1, 1);
    const numbers = (size: number) => new THREE.InstancedBufferAttribute(new Float32Array(size * capacity), size);
    geometry.setAttribute('shape', numbers(NUMBERS));
    geometry.setAttribute('tint', numbers(3));
    const mesh = new THREE.InstancedMesh(geometry, this.material, capacity);
    mesh.count = 0;
    mesh.frustumCulled = false;
    mesh.renderOrder = 3;
    this.parent.add(mesh);
    return mesh;
  }
}
