/** The chosen map, in the column on the right: what it is, how time passes in it, and the materials of its surfaces. */

import type { Scene } from '../protocol/scene';
import type { State } from '../state';
import { find, make } from './dom';

interface Material {
  name: string;
  friction: number;
  colour: readonly number[];
  /** Number of solids and objects of it. */
  count: number;
}

export class MapPanel {
  private readonly element = make('section', { id: 'map-facts', 'aria-label': 'Map', hidden: '' });
  private shown: Scene | null = null;

  constructor(private readonly state: State) {
    find('drive').prepend(this.element);
  }

  update(): void {
    const { scene, isMapChosen } = this.state;
    this.element.hidden = !isMapChosen || scene === null;
    if (!scene || this.element.hidden || this.shown === scene) return;
    this.shown = scene;
    const { map, time_step: step, seed } = scene;
    const time = step === null ? '' : `A step is ${Number((1000 * step).toPrecision(6))} ms, the seed ${seed}.`;
    const rows = materialsOf(scene).map(({ name, friction, colour, count }) => {
      const swatch = make('i', { class: 'swatch' });
      swatch.style.background = `rgb(${colour.map((part) => Math.round(255 * part)).join()})`;
      return make(
        'tr',
        {},
        make('td', {}, swatch, name),
        make('td', { class: 'number' }, String(friction)),
        make('td', { class: 'number quiet' }, String(count)),
      );
    });
    const head = make('tr', {}, make('th', {}, 'Material'), make('th', {}, 'friction'), make('th', {}, 'parts'));
    this.element.replaceChildren(
      make('h2', {}, map.name),
      make('p', {}, map.description),
      make('p', { class: 'quiet' }, time),
      ...(rows.length > 0 ? [make('table', { class: 'materials' }, head, ...rows)] : []),
    );
  }
}

/** Returns the materials of a map's solids and objects, the most frequent first. */
export function materialsOf({ map }: Scene): Material[] {
  const found = new Map<string, Material>();
  for (const { material: name, friction, colour } of [...map.solids, ...map.objects]) {
    const known = found.get(name) ?? { name, friction, colour, count: 0 };
    known.count += 1;
    found.set(name, known);
  }
  return [...found.values()].toSorted((one, other) => other.count - one.count);
}
