/** Light from everywhere and a key light with a soft shadow, which covers what is looked at. */

import * as THREE from 'three';
import { LIGHT } from './colours';

/** Direction from which the key light comes, on the stage. */
export const LIGHT_FROM = new THREE.Vector3(-0.42, 0.3, 0.86).normalize();
const MAP_SIZE = 1024;
/** The least and the greatest half edge of what has shadows, m. */
const LEAST_REACH = 1.5;
const GREATEST_REACH = 90;

export class Lights {
  readonly group = new THREE.Group();
  private readonly ambient = new THREE.HemisphereLight();
  private readonly key = new THREE.DirectionalLight();
  private readonly centre = new THREE.Vector3();
  private reach = 0;

  constructor() {
    const { shadow } = this.key;
    shadow.mapSize.set(MAP_SIZE, MAP_SIZE);
    shadow.radius = 2.2;
    shadow.bias = -0.0006;
    this.ambient.position.set(0, 0, 1);
    this.ambient.color.set(LIGHT.fromSky);
    this.ambient.groundColor.set(LIGHT.fromGround);
    this.key.color.set(LIGHT.key);
    this.key.intensity = LIGHT.keyStrength;
    this.group.add(this.ambient, this.key, this.key.target);
  }

  /** Sets the ambient light. An environment gives a part of it. */
  setEnvironment(has: boolean): void {
    this.ambient.intensity = LIGHT.ambient * (has ? 0.6 : 1);
  }

  castShadows(casts: boolean): void {
    this.key.castShadow = casts;
  }

  /** Lights what is around a place; says whether the shadows must be drawn anew because of that. */
  cover(place: THREE.Vector3, wanted: number): boolean {
    const reach = Math.min(GREATEST_REACH, Math.max(LEAST_REACH, wanted));
    // Not at every small step: every new shadow map costs, and its edges would swim.
    const fits = reach < this.reach * 1.15 && reach > this.reach * 0.6;
    if (fits && place.distanceTo(this.centre) < this.reach * 0.2) return false;
    this.reach = fits ? this.reach : reach * 1.1;
    this.centre.copy(place);
    this.key.target.position.copy(place);
    this.key.position.copy(place).addScaledVector(LIGHT_FROM, 3 * this.reach);
    const camera = this.key.shadow.camera;
    Object.assign(camera, { left: -this.reach, right: this.reach, top: this.reach, bottom: -this.reach });
    Object.assign(camera, { near: 0.2 * this.reach, far: 6 * this.reach });
    camera.updateProjectionMatrix();
    // Some pixels of the map, so that slanted faces do not shade themselves.
    this.key.shadow.normalBias = (2.5 * 2 * this.reach) / MAP_SIZE;
    return true;
  }
}
