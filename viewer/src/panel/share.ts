/** The dialog to show others what is shown here: a link, a picture of any size, a clip of a time. */

import { type Link, writeLink } from '../link';
import type { Playback } from '../playback';
import { rollPitchYaw } from '../protocol/frame';
import type { Vector } from '../protocol/scene';
import type { State } from '../state';
import type { Looks, View } from '../view/view';
import { closeDialog, showDialog } from './dialog';
import { find, make, save } from './dom';
import './share.css';

/** Sizes of pictures, px. */
const SIZES = [
  [1280, 720],
  [1920, 1080],
  [3840, 2160],
  [1080, 1080],
] as const;
/** Longest clip, s, and its pictures a second. */
const LONGEST = 60;
const RATE = 30;
/** Length of the clip that is offered, s. */
const OFFERED = 10;

export class Sharing {
  constructor(
    private readonly state: State,
    private readonly view: View,
    private readonly playback: Playback,
    private readonly say: (text: string) => void,
  ) {}

  open(): void {
    void showDialog('Share', this.link(), this.picture(), this.clip());
  }

  private link(): HTMLElement {
    const text = `${location.origin}${location.pathname}#${writeLink(this.shown())}`;
    const field = make('input', { readonly: '', value: text, 'aria-label': 'Link', id: 'share-link' });
    const copy = make('button', { type: 'button', class: 'main' }, 'Copy the link');
    copy.onclick = () => {
      field.select();
      // Without a secure connection browsers copy what is selected alone.
      const copied = navigator.clipboard?.writeText(text) ?? Promise.resolve(void document.execCommand('copy'));
      copied.then(
        () => this.say('The link is copied'),
        () => this.say('The link is selected: copy it'),
      );
    };
    const { logName } = this.playback;
    const what = logName
      ? `It opens this view; whoever drops ${logName} there sees this moment.`
      : 'It opens this map with these robots and this view, where this page can be reached.';
    return make('section', {}, make('div', { class: 'row' }, field, copy), make('p', { class: 'quiet' }, what));
  }

  /** Lists all that a link has to bring back. */
  private shown(): Link {
    const { scene, status, frame } = this.state;
    const { logName } = this.playback;
    const robots = (status?.robots ?? []).flatMap(({ id, class: robotClass }) => {
      const pose = this.state.robotState(id)?.pose;
      if (!pose) return [];
      const [x, y, z] = pose;
      return [{ robotClass, location: [x, y, z] as Vector, yaw: rollPitchYaw(pose)[2] }];
    });
    return {
      map: scene?.map.name ?? null,
      robots: logName ? [] : robots,
      camera: this.view.viewpoint,
      log: logName ? { name: logName, time: frame?.time ?? 0 } : null,
    };
  }

  private picture(): HTMLElement {
    const size = make('select', { 'aria-label': 'Size', id: 'share-size' }, make('option', { value: '' }, 'as it is'));
    size.append(...SIZES.map(([x, y]) => make('option', { value: `${x},${y}` }, `${x} x ${y}`)));
    const parts = (['grid', 'floor', 'background', 'labels'] as const).map((part) => {
      const box = make('input', { type: 'checkbox', name: part });
      box.checked = part === 'floor' || part === 'background';
      return box;
    });
    const button = make('button', { type: 'button', id: 'share-picture' }, 'Save PNG');
    button.onclick = () => {
      const [width, height] = size.value.split(',').map(Number);
      const looks: Partial<Looks> = Object.fromEntries(parts.map(({ name, checked }) => [name, checked]));
      void this.savePicture(width && height ? { width, height } : null, looks);
    };
    const labels = parts.map((box) => make('label', {}, box, ` ${box.name}`));
    const row = make('div', { class: 'row' }, size, ...labels, button);
    return make('section', {}, make('h3', {}, 'Picture'), row);
  }

  /** Saves the view as a PNG, as large as is wanted; null for all pixels of the screen. */
  async savePicture(size: { width: number; height: number } | null, looks: Partial<Looks> = {}): Promise<void> {
    const picture = await this.view.screenshot(size, looks);
    if (picture) save(picture, `${this.fileName()}.png`);
  }

  private fileName(): string {
    const { frame, scene } = this.state;
    return `usarsim-${scene?.map.name ?? 'world'}-${(frame?.time ?? 0).toFixed(1)}s`;
  }

  private clip(): HTMLElement {
    const [first, last] = this.playback.range;
    const now = this.playback.mode === 'live' ? last : (this.state.frame?.time ?? last);
    const field = (name: string, value: number) =>
      make('input', { type: 'number', 'aria-label': name, step: '0.1', value: value.toFixed(1), size: '6' });
    const from = field('From', Math.max(first, now - OFFERED));
    const to = field('To', now);
    const button = make('button', { type: 'button', id: 'share-clip' }, 'Save WebM');
    button.disabled = typeof MediaRecorder === 'undefined' || !MediaRecorder.isTypeSupported('video/webm');
    button.onclick = () => {
      const [start, end] = [from, to].map(({ value }) => Math.min(last, Math.max(first, Number(value) || 0)));
      if (start === undefined || end === undefined || end <= start || end - start > LONGEST) {
        return this.say(`A clip ends after it begins, and has at most ${LONGEST} s: got ${from.value} to ${to.value}`);
      }
      closeDialog();
      void this.saveClip(start, end);
    };
    const row = make('div', { class: 'row' }, from, 's to', to, 's', button);
    const what = `It is filmed as it plays. Between ${first.toFixed(1)} and ${last.toFixed(1)} s there is something to see.`;
    return make('section', {}, make('h3', {}, 'Clip'), row, make('p', { class: 'quiet' }, what));
  }

  /** Plays a time and films it. */
  private async saveClip(start: number, end: number): Promise<void> {
    const canvas = find<HTMLCanvasElement>('canvas');
    const recorder = new MediaRecorder(canvas.captureStream(RATE), { mimeType: 'video/webm', videoBitsPerSecond: 8e6 });
    const parts: Blob[] = [];
    recorder.ondataavailable = ({ data }) => parts.push(data);
    const stopped = new Promise((resolve) => (recorder.onstop = resolve));
    const name = this.fileName();
    const { mode } = this.playback;
    this.playback.goTo(start);
    recorder.start(500);
    if (this.playback.isPaused) this.playback.playOrPause();
    // Somebody may stop it, or return to the present: the clip ends there.
    const isOn = () => this.playback.mode !== 'live' && !this.playback.isPaused && (this.state.frame?.time ?? 0) < end;
    await new Promise((resolve) => setTimeout(resolve, 200));
    while (isOn()) await new Promise((resolve) => setTimeout(resolve, 50));
    recorder.stop();
    await stopped;
    if (mode === 'live') this.playback.goLive();
    else if (!this.playback.isPaused) this.playback.playOrPause();
    save(new Blob(parts, { type: 'video/webm' }), `${name}.webm`);
    this.say('The clip is saved');
  }
}
