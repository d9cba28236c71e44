/** Looks of materials: one drawing material for all solids of a kind, plain, matte or standard by the rung of quality. */

import * as THREE from 'three';
import { plainMaterial } from './plain';
import { PATTERNS, type PatternName, patternTexture } from './textures';

interface Surface {
  /** Patterns of the physical materials' names. */
  names: RegExp;
  pattern: PatternName | null;
  roughness: number;
  metalness: number;
  /** Lies on other surfaces: it is in front of them where both are as far. */
  lies?: boolean;
}

const SURFACES = {
  ice: { names: /ice|acrylic|glass|perspex/, pattern: 'ice', roughness: 0.18, metalness: 0 },
  wood: { names: /wood|ply|board|mdf|osb|timber|parquet/, pattern: 'wood', roughness: 0.75, metalness: 0 },
  carpet: { names: /carpet|felt|cloth|grass|foam/, pattern: 'carpet', roughness: 1, metalness: 0 },
  metal: { names: /alumin|steel|metal|iron|brass|copper/, pattern: 'metal', roughness: 0.38, metalness: 0.75 },
  rubber: { names: /rubber|tyre|tire|roller/, pattern: 'rubber', roughness: 0.92, metalness: 0 },
  sand: { names: /sand|gravel|soil|earth|dirt|mulch/, pattern: 'sand', roughness: 1, metalness: 0 },
  plastic: { names: /plastic|nylon|pvc|abs|polyamide|delrin/, pattern: null, roughness: 0.45, metalness: 0 },
  concrete: { names: /concrete|stone|brick|asphalt|tile|cement/, pattern: 'concrete', roughness: 0.93, metalness: 0 },
  robot: { names: /^$/, pattern: null, roughness: 0.5, metalness: 0.15 },
  marking: { names: /^$/, pattern: null, roughness: 0.9, metalness: 0, lies: true },
  unknown: { names: /./, pattern: 'concrete', roughness: 0.85, metalness: 0 },
} satisfies Record<string, Surface>;

export type SurfaceName = keyof typeof SURFACES;

/** Lit in the corners, in each pixel by Lambert's law, or with reflections. */
export type Shading = 'plain' | 'matte' | 'standard';

export function surfaceOf(material: string): SurfaceName {
  const names = Object.keys(SURFACES) as SurfaceName[];
  return names.find((name) => SURFACES[name].names.test(material.toLowerCase())) ?? 'unknown';
}

/** Returns the length of a surface that its picture covers, m. */
export function tileOf(name: SurfaceName): number {
  const { pattern }: Surface = SURFACES[name];
  return pattern ? PATTERNS[pattern].tile : 1;
}

export class Surfaces {
  private shading: Shading = 'plain';
  private readonly textures = new Map<PatternName, ReturnType<typeof patternTexture>>();
  private readonly materials = new Map<string, THREE.Material>();

  constructor(private readonly anisotropy: number) {}

  /** Sets the finish of all materials from now on. */
  setShading(shading: Shading): void {
    this.shading = shading;
  }

  /** The material that a kind of surface has now. */
  material(name: SurfaceName): THREE.Material {
    const key = `${name} ${this.shading}`;
    const material = this.materials.get(key) ?? this.make(SURFACES[name]);
    this.materials.set(key, material);
    return material;
  }

  /** Gives a mesh a surface that follows the quality. */
  cover(mesh: THREE.Mesh, name: SurfaceName): void {
    mesh.userData.surface = name;
    mesh.material = this.material(name);
  }

  /** Gives every mesh under an object the material that its surface has now. */
  refresh(root: THREE.Object3D): void {
    root.traverse((object) => {
      if (object instanceof THREE.Mesh && object.userData.surface) {
        object.material = this.material(object.userData.surface as SurfaceName);
      }
    });
  }

  private make({ pattern, roughness, metalness, lies }: Surface): THREE.Material {
    const picture = pattern ? this.picture(pattern) : null;
    const material = this.shaded(picture, roughness, metalness);
    // So that edges and the grid lie on it and not in it.
    const [polygonOffsetFactor, polygonOffsetUnits] = lies ? [-0.5, -8] : [1, 2];
    return Object.assign(material, { polygonOffset: true, polygonOffsetFactor, polygonOffsetUnits });
  }

  private shaded(
    picture: ReturnType<typeof patternTexture> | null,
    roughness: number,
    metalness: number,
  ): THREE.Material {
    if (this.shading === 'plain') return plainMaterial(picture);
    const color = new THREE.Color().setScalar(1 / (picture?.mean ?? 1));
    const matte = { vertexColors: true, map: picture?.texture ?? null, color };
    if (this.shading === 'matte') return new THREE.MeshLambertMaterial(matte);
    const relief = picture && { bumpMap: picture.texture, bumpScale: 0.012 };
    return new THREE.MeshStandardMaterial({ ...matte, ...relief, roughness, metalness });
  }

  private picture(pattern: PatternName): ReturnType<typeof patternTexture> {
    const picture = this.textures.get(pattern) ?? patternTexture(pattern);
    picture.texture.anisotropy = this.anisotropy;
    this.textures.set(pattern, picture);
    return picture;
  }
}
