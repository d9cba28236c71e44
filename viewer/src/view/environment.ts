/** Environment that shiny things reflect: a sky, a floor and three soft lamps, blurred for each roughness. */

import * as THREE from 'three';

/** Place, size and brightness of a lamp; metres from the middle. */
const LAMPS: [THREE.Vector3Tuple, [number, number], number][] = [
  [[-4, 3, 7], [5, 3], 9],
  [[6, -2, 5], [2, 5], 5],
  [[-2, -7, 3], [6, 1.2], 3.5],
];

export function makeEnvironment(renderer: THREE.WebGLRenderer): THREE.Texture {
  const scene = new THREE.Scene();
  const dome = new THREE.SphereGeometry(12, 24, 16);
  const places = dome.getAttribute('position');
  const colours = new Float32Array(3 * places.count);
  const [floor, horizon, zenith] = ['#6d6a66', '#dfe5ec', '#9db4cc'].map((colour) => new THREE.Color(colour));
  const colour = new THREE.Color();
  for (let corner = 0; corner < places.count; corner++) {
    const up = places.getZ(corner) / 12;
    if (up < -0.05) colour.copy(floor ?? colour);
    else colour.copy(horizon ?? colour).lerp(zenith ?? colour, Math.max(0, up));
    colour.toArray(colours, 3 * corner);
  }
  dome.setAttribute('color', new THREE.BufferAttribute(colours, 3));
  scene.add(new THREE.Mesh(dome, new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.BackSide })));
  for (const [place, size, brightness] of LAMPS) {
    const material = new THREE.MeshBasicMaterial({
      color: new THREE.Color().setScalar(brightness),
      side: THREE.DoubleSide,
    });
    const lamp = new THREE.Mesh(new THREE.PlaneGeometry(...size), material);
    lamp.position.set(...place);
    lamp.lookAt(0, 0, 0);
    scene.add(lamp);
  }
  const generator = new THREE.PMREMGenerator(renderer);
  const { texture } = generator.fromScene(scene, 0.04);
  generator.dispose();
  scene.traverse((object) => {
    if (!(object instanceof THREE.Mesh)) return;
    object.geometry.dispose();
    (object.material as THREE.Material).dispose();
  });
  return texture;
}
