/** Material of what lies on the floor and is drawn by shaders of its own. */

import * as THREE from 'three';

/** Returns such a material; parameters may say otherwise. */
export function lyingMaterial(parameters: THREE.ShaderMaterialParameters): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    transparent: true,
    depthWrite: false,
    // A floor and what lies on it are both large and almost in one plane: without an offset the floor hides parts of it.
    polygonOffset: true,
    polygonOffsetFactor: -1,
    polygonOffsetUnits: -16,
    ...parameters,
  });
}
