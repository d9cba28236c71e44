/** A line of some pixels about a robot or an object, also where something stands before it. */

import * as THREE from 'three';

/** Breadth of the line as a part of the robot: it is thinner about a robot that is small on the screen, and never finer than the pixels that are drawn. */
const BREADTH = 2.4;
const PART_OF_ROBOT = 0.02;

const MASK_VERTEX = `
  void main() {
    gl_Position = projectionMatrix * modelViewMatrix * instanceMatrix * vec4(position, 1.0);
  }`;
const HULL_VERTEX = `
  attribute vec3 outward;
  uniform vec2 screen;
  uniform float breadth;
  void main() {
    mat4 seen = modelViewMatrix * instanceMatrix;
    gl_Position = projectionMatrix * seen * vec4(position, 1.0);
    vec2 aside = (projectionMatrix * vec4(mat3(seen) * outward, 0.0)).xy;
    gl_Position.xy += 2.0 * breadth * normalize(aside * screen + 1e-6) / screen * gl_Position.w;
  }`;
const FRAGMENT = `
  uniform vec3 colour;
  void main() {
    gl_FragColor = vec4(colour, 1.0);
    #include <colorspace_fragment>
  }`;

/** A part and its place in the world. A part is the same one from frame to frame. */
export interface Outlined {
  part: { mesh: THREE.Mesh };
  matrix: THREE.Matrix4;
}

export class Outline {
  readonly group = new THREE.Group();
  private readonly uniforms = {
    screen: { value: new THREE.Vector2(1, 1) },
    breadth: { value: BREADTH },
    colour: { value: new THREE.Color() },
  };
  private ratio = 1;
  /** Marks where the robot is seen, so that the line is drawn about it alone. */
  private readonly mask = new THREE.ShaderMaterial({
    vertexShader: MASK_VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: this.uniforms,
    transparent: true,
    colorWrite: false,
    depthWrite: false,
    depthTest: false,
    stencilWrite: true,
    stencilRef: 1,
    stencilZPass: THREE.ReplaceStencilOp,
  });
  private readonly hull = new THREE.ShaderMaterial({
    vertexShader: HULL_VERTEX,
    fragmentShader: FRAGMENT,
    uniforms: this.uniforms,
    transparent: true,
    depthWrite: false,
    depthTest: false,
    stencilWrite: true,
    stencilRef: 1,
    stencilFunc: THREE.NotEqualStencilFunc,
    side: THREE.DoubleSide,
  });
  private readonly parts = new Map<Outlined['part'], { mask: THREE.InstancedMesh; hull: THREE.InstancedMesh }>();

  resize(width: number, height: number, ratio: number): void {
    this.uniforms.screen.value.set(width, height);
    this.ratio = ratio;
  }

  /** Suits a robot that is so large on the screen, px. */
  suit(robot: number): void {
    this.uniforms.breadth.value = Math.max(1 / this.ratio, Math.min(BREADTH, PART_OF_ROBOT * robot));
  }

  /** About these parts, or about nothing. */
  place(placed: Outlined[], colour: string): void {
    this.uniforms.colour.value.set(colour);
    const counts = new Map<Outlined['part'], number>();
    for (const { part } of placed) counts.set(part, (counts.get(part) ?? 0) + 1);
    this.parts.forEach(({ mask, hull }, part) => {
      mask.count = hull.count = 0;
      mask.visible = hull.visible = counts.has(part);
    });
    for (const { part, matrix } of placed) {
      if (!part.mesh.geometry.hasAttribute('position')) continue;
      const { mask, hull } = this.meshes(part, counts.get(part) ?? 1);
      mask.setMatrixAt(mask.count++, matrix);
      hull.setMatrixAt(hull.count++, matrix);
      mask.instanceMatrix.needsUpdate = hull.instanceMatrix.needsUpdate = true;
    }
  }

  /** Forgets the parts of a world that is no more. */
  clear(): void {
    this.parts.forEach(({ mask, hull }) => [mask, hull].forEach((mesh) => mesh.dispose()));
    this.parts.clear();
    this.group.clear();
  }

  private meshes(part: Outlined['part'], count: number): { mask: THREE.InstancedMesh; hull: THREE.InstancedMesh } {
    const known = this.parts.get(part);
    if (known && known.mask.instanceMatrix.count >= count) return known;
    if (known) this.group.remove(known.mask, known.hull);
    const { geometry } = part.mesh;
    if (!geometry.hasAttribute('outward')) geometry.setAttribute('outward', outward(geometry));
    const make = (material: THREE.Material, order: number) => {
      const mesh = new THREE.InstancedMesh(geometry, material, count);
      mesh.count = 0;
      mesh.frustumCulled = false;
      mesh.renderOrder = order;
      this.group.add(mesh);
      return mesh;
    };
    const made = { mask: make(this.mask, 7), hull: make(this.hull, 8) };
    this.parts.set(part, made);
    return made;
  }
}

/** Normals that all corners at one place share, so that the line has no gaps where faces meet. */
function outward(geometry: THREE.BufferGeometry): THREE.BufferAttribute {
  const [places, normals] = [geometry.getAttribute('position'), geometry.getAttribute('normal')];
  const sums = new Map<string, THREE.Vector3>();
  const keys = Array.from({ length: places.count }, (_, corner) => {
    const key = [places.getX(corner), places.getY(corner), places.getZ(corner)].map((at) => at.toFixed(4)).join();
    const sum = sums.get(key) ?? new THREE.Vector3();
    sums.set(key, sum.add(new THREE.Vector3().fromBufferAttribute(normals, corner)));
    return key;
  });
  const shared = new Float32Array(3 * places.count);
  keys.forEach((key, corner) =>
    sums
      .get(key)
      ?.clone()
      .normalize()
      .toArray(shared, 3 * corner),
  );
  return new THREE.BufferAttribute(shared, 3);
}
