/** Draws with ambient occlusion: corners and what is under things get less light. For machines that can afford it. */

import * as THREE from 'three';
import { EffectComposer } from 'three/addons/postprocessing/EffectComposer.js';
import { GTAOPass } from 'three/addons/postprocessing/GTAOPass.js';
import { OutputPass } from 'three/addons/postprocessing/OutputPass.js';
import { RenderPass } from 'three/addons/postprocessing/RenderPass.js';

/** Distance up to which things keep light from each other, m. */
const REACH = 0.3;
/** Samples of a pixel at the edges of things. */
const SAMPLES = 4;

/** Leaves out of the depths what has no body. */
class BodiesOnly extends GTAOPass {
  bodiless: () => THREE.Object3D[] = () => [];

  override render(...parameters: Parameters<GTAOPass['render']>): void {
    const hidden = this.bodiless().filter(({ visible }) => visible);
    hidden.forEach((object) => (object.visible = false));
    super.render(...parameters);
    hidden.forEach((object) => (object.visible = true));
  }
}

export class OcclusionRenderer {
  private readonly composer: EffectComposer;
  private readonly pass: BodiesOnly;
  private readonly output = new OutputPass();

  constructor(
    private readonly renderer: THREE.WebGLRenderer,
    scene: THREE.Scene,
    camera: THREE.Camera,
    bodiless: () => THREE.Object3D[],
  ) {
    const target = new THREE.WebGLRenderTarget(1, 1, {
      type: THREE.HalfFloatType,
      samples: SAMPLES,
      stencilBuffer: true,
    });
    this.composer = new EffectComposer(renderer, target);
    this.pass = new BodiesOnly(scene, camera, 1, 1);
    this.pass.bodiless = bodiless;
    this.pass.updateGtaoMaterial({ radius: REACH, distanceExponent: 1.2, thickness: 1, scale: 1.2, samples: 12 });
    this.pass.blendIntensity = 0.9;
    this.composer.addPass(new RenderPass(scene, camera));
    this.composer.addPass(this.pass);
    this.composer.renderToScreen = false;
  }

  resize(width: number, height: number, ratio: number): void {
    this.composer.setPixelRatio(ratio);
    this.composer.setSize(width, height);
  }

  /** Draws on the canvas, or aside. */
  render(target: THREE.WebGLRenderTarget | null = null): void {
    this.composer.render();
    this.output.renderToScreen = target === null;
    this.output.render(this.renderer, target ?? this.composer.writeBuffer, this.composer.readBuffer, 0, false);
    this.renderer.setRenderTarget(null);
  }
}
