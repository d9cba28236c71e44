/** The world bar: time and what can be done with it. */

import type { Live } from '../protocol/live';
import type { State } from '../state';
import { LAYERS } from '../view/overlay';
import type { CameraMode, View } from '../view/view';
import { find, make, remember, remembered, setText } from './dom';
import { isForControl } from './keys';

/** Layers that are shown at first. */
const FIRST_LAYERS = ['paths', 'rays', 'names', 'grid'];

export class Bar {
  private readonly pause = find<HTMLButtonElement>('pause');
  private readonly record = find<HTMLButtonElement>('record');
  private readonly speed = find<HTMLSelectElement>('speed');
  private readonly camera = find<HTMLSelectElement>('camera');

  constructor(
    private readonly state: State,
    live: Live,
    private readonly view: View,
  ) {
    this.pause.onclick = () => live.control({ pause: !state.status?.paused });
    find('step').onclick = () => live.control({ step: 1 });
    find('reset').onclick = () => live.control('reset');
    this.record.onclick = () => live.control({ record: state.status?.recording === null });
    this.speed.onchange = () => live.control({ speed: Number(this.speed.value) });
    this.camera.onchange = () => this.look();
    find('screenshot').onclick = () => void this.savePicture();
    find('theme').onclick = () => this.setTheme(document.documentElement.dataset.theme !== 'dark');
    find('toggle-panel').onclick = () => (find('panel').hidden = !find('panel').hidden);
    window.addEventListener('keydown', (event) => this.key(event, true));
    window.addEventListener('keyup', (event) => this.key(event, false));
    const dark = matchMedia('(prefers-color-scheme: dark)').matches;
    this.setTheme(remembered('theme') === null ? dark : remembered('theme') === 'dark');
    this.buildLayers();
  }

  /** The camera looks at the selected robot. */
  look(): void {
    this.view.look(this.camera.value as CameraMode, this.state.selected);
  }

  updateFrame(): void {
    if (this.state.frame) setText(find('time'), this.state.frame.time.toFixed(3));
  }

  updateStatus(): void {
    const { status, scene } = this.state;
    if (!status) return;
    setText(find('map'), scene?.map.name ?? 'usarsim');
    setText(find('factor'), status.paused ? '0' : status.real_time_factor.toFixed(2));
    setText(this.pause, status.paused ? 'Resume' : 'Pause');
    this.pause.setAttribute('aria-pressed', String(status.paused));
    setText(this.record, status.recording ? 'Stop recording' : 'Record');
    this.record.setAttribute('aria-pressed', String(status.recording !== null));
    this.record.title = status.recording ?? 'Write an MCAP log on the server';
    const speed = String(status.speed);
    if (![...this.speed.options].some(({ value }) => value === speed)) {
      this.speed.append(make('option', { value: speed }, `${speed} ×`));
    }
    if (document.activeElement !== this.speed) this.speed.value = speed;
  }

  private key(event: KeyboardEvent, down: boolean): void {
    if (event.ctrlKey || event.metaKey || event.altKey || isForControl(event, this.state.driving)) return;
    if (event.key === ' ') {
      // Else the button that has the focus is pressed, too; some browsers do so when the key comes up.
      event.preventDefault();
      if (down && !event.repeat) this.pause.click();
    }
    if (event.key === '.' && down) find('step').click();
  }

  private setTheme(dark: boolean): void {
    document.documentElement.dataset.theme = dark ? 'dark' : 'light';
    remember('theme', dark ? 'dark' : 'light');
    this.view.setDark(dark);
  }

  private buildLayers(): void {
    const shown = remembered('layers')?.split(',') ?? FIRST_LAYERS;
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

  private async savePicture(): Promise<void> {
    const picture = await this.view.screenshot();
    if (!picture) return;
    const url = URL.createObjectURL(picture);
    const { frame, scene } = this.state;
    const name = `usarsim-${scene?.map.name ?? 'world'}-${(frame?.time ?? 0).toFixed(1)}s.png`;
    make('a', { href: url, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(url), 10_000);
  }
}
