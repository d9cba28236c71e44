/**
 * The material of the low rungs: light, haze and tone are worked out in the corners, and a pixel is one look at the picture. Without
 * a graphics card that is a fifth of the whole time of a frame less than Lambert's by pixel.
 */

import * as THREE from 'three';
import { BENT } from './tone';

const VERTEX = `
  struct Key { vec3 direction; vec3 color; };
  struct Ambient { vec3 direction; vec3 skyColor; vec3 groundColor; };
  uniform Key directionalLights[1];
  uniform Ambient hemisphereLights[1];
  uniform vec3 fogColor;
  varying vec2 at;
  varying float depth;
  varying vec3 shade;
  flat varying vec3 haze;
  ${BENT}
  vec3 encoded(vec3 linear) {
    return mix(1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, 12.92 * linear, step(linear, vec3(0.0031308)));
  }
  void main() {
    vec4 place = vec4(position, 1.0);
    vec3 upright = normal;
    #ifdef USE_INSTANCING
      place = instanceMatrix * place;
      upright = mat3(instanceMatrix) * upright;
    #endif
    vec4 seen = modelViewMatrix * place;
    upright = normalize(normalMatrix * upright);
    float above = 0.5 * dot(upright, hemisphereLights[0].direction) + 0.5;
    vec3 light = mix(hemisphereLights[0].groundColor, hemisphereLights[0].skyColor, above);
    light += max(dot(upright, directionalLights[0].direction), 0.0) * directionalLights[0].color;
    shade = encoded(bent(color * light / ${Math.PI}));
    haze = encoded(fogColor);
    at = uv;
    depth = -seen.z;
    gl_Position = projectionMatrix * seen;
  }`;

const FRAGMENT = `
  uniform sampler2D picture;
  uniform float mean;
  uniform float fogNear;
  uniform float fogFar;
  varying vec2 at;
  varying float depth;
  varying vec3 shade;
  flat varying vec3 haze;
  void main() {
    vec3 colour = shade;
    #ifdef HAS_PICTURE
      // The picture is of light: what the eye is shown has the root of it, here its tangent at the mean.
      colour *= 1.0 + (texture2D(picture, at).r / mean - 1.0) / 2.2;
    #endif
    gl_FragColor = vec4(mix(colour, haze, smoothstep(fogNear, fogFar, depth)), 1.0);
  }`;

/** Matte, in the colours of the corners, with a picture that is so light in the mean or without one. */
export function plainMaterial(picture: { texture: THREE.Texture; mean: number } | null): THREE.ShaderMaterial {
  const { lights, fog } = THREE.UniformsLib;
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    defines: picture ? { HAS_PICTURE: 1 } : {},
    uniforms: {
      ...THREE.UniformsUtils.merge([lights, fog]),
      picture: { value: picture?.texture ?? null },
      mean: { value: picture?.mean ?? 1 },
    },
    vertexColors: true,
    lights: true,
    fog: true,
  });
}
