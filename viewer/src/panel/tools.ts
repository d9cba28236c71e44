/** Tools in the view: cameras and layers. */

import type { State } from '../state';
import { FIRST_LAYERS, LAYERS } from '../view/overlay';
import { CAMERAS, type CameraMode, type View } from '../view/view';
import { find, make, remember, remembered } from './dom';

export class Tools {
  private readonly camera = find<HTMLSelectElement>('camera');
  /** Camera before that of the robot. */
  private before: CameraMode = 'orbit';

  constructor(
    private readonly state: State,
    private readonly view: View,
  ) {
    this.camera.append(...CAMERAS.map((mode) => make('option', { value: mode }, mode)));
    this.camera.onchange = () => this.look();
    view.onCamera = (mode) => (this.camera.value = mode);
    find('fit').onclick = () => view.fit(state.selected);
    find('home').onclick = () => view.home();
    this.buildLayers();
    document.addEventListener('pointerdown', ({ target }) => {
      const layers = find<HTMLDetailsElement>('layers');
      if (layers.open && target instanceof Node && !layers.contains(target)) layers.open = false;
    });
  }

  /** The camera looks at the selected robot. */
  look(mode = this.camera.value as CameraMode): void {
    this.camera.value = mode;
    this.view.look(mode, this.state.selected);
  }

  /** Looks through the selected robot's camera, or as before. */
  swapRobotsView(): void {
    const [mode, before] = [this.camera.value as CameraMode, this.before];
    this.before = mode;
    this.look(mode === 'robot' ? before : 'robot');
  }

  /** The next camera, for a key. */
  nextCamera(): void {
    const next = CAMERAS[(CAMERAS.indexOf(this.camera.value as CameraMode) + 1) % CAMERAS.length];
    this.look(next);
  }

  private buildLayers(): void {
    const shown: readonly string[] = remembered('layers')?.split(',') ?? FIRST_LAYERS;
    const boxes = LAYERS.map((layer) => {
      const box = make('input', { type: 'checkbox', name: layer });
      box.checked = shown.includes(layer);
      this.view.show(layer, box.checked);
      box.onchange = () => {
        this.view.show(layer, box.checked);
        remember('layers', LAYERS.filter((_, index) => boxes[index]?.checked).join(','));
      };
      return box;
    });
    const menu = find('layers').querySelector('.menu');
    boxes.forEach((box) => menu?.append(make('label', {}, box, ` ${box.name}`)));
  }
}
