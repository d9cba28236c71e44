/** Tools in the view: cameras and layers. */

import type { State } from '../state';
import { DEPTH_COLOURS, depthRange } from '../view/depth';
import { FIRST_LAYERS, LAYERS } from '../view/overlay';
import { CAMERAS, type CameraMode, type View } from '../view/view';
import { find, make, remember, remembered, setText } from './dom';

export class Tools {
  private readonly camera = find<HTMLSelectElement>('camera');
  private readonly depths = make(
    'div',
    { id: 'depths', 'aria-label': 'Colours of depth', hidden: '' },
    make('span'),
    make('i', { style: `background: linear-gradient(to right, ${DEPTH_COLOURS.join(', ')})` }),
    make('span'),
  );
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

  /** Shows which colour is how far; to be called a few times a second. */
  updateDepths(): void {
    const [first, last] = this.depths.querySelectorAll('span');
    const [near, far] = depthRange(this.view.distance).map((metres) => `${metres.toPrecision(2)} m`);
    if (first && last && near && far) [setText(first, near), setText(last, far)];
  }

  private showDepths(shown: boolean): void {
    this.depths.hidden = !shown;
    find('view').append(this.depths);
  }

  private buildLayers(): void {
    const shown: readonly string[] = remembered('layers')?.split(',') ?? FIRST_LAYERS;
    const boxes = LAYERS.map((layer) => {
      const box = make('input', { type: 'checkbox', name: layer });
      // What is drawn by its depth alone would puzzle whoever comes back another day.
      box.checked = shown.includes(layer) && layer !== 'depth';
      this.view.show(layer, box.checked);
      box.onchange = () => {
        this.view.show(layer, box.checked);
        if (layer === 'depth') this.showDepths(box.checked);
        remember('layers', LAYERS.filter((_, index) => boxes[index]?.checked).join(','));
      };
      return box;
    });
    const menu = find('layers').querySelector('.menu');
    boxes.forEach((box) => menu?.append(make('label', {}, box, ` ${box.name}`)));
  }
}
