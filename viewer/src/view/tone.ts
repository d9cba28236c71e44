/** Bright colours are bent towards white instead of being cut off; the others stay as they are. */

import * as THREE from 'three';

const PLAIN = 'vec3 CustomToneMapping( vec3 color ) { return color; }';
/** Compresses brightness from 0.75 on, never quite to 1. */
export const BENT = `vec3 bent( vec3 color ) {
  vec3 over = max( color - 0.75, 0.0 );
  return min( color, 0.75 ) + over / ( 1.0 + 4.0 * over );
}`;
const CUSTOM = `${BENT}
vec3 CustomToneMapping( vec3 color ) { return bent( toneMappingExposure * color ); }`;

export function setToneMapping(renderer: THREE.WebGLRenderer): void {
  const chunks = THREE.ShaderChunk as Record<string, string>;
  chunks.tonemapping_pars_fragment = (chunks.tonemapping_pars_fragment ?? '').replace(PLAIN, CUSTOM);
  renderer.toneMapping = THREE.CustomToneMapping;
}
