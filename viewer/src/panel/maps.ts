/** The dialog to choose a map. */

import type { Live } from '../protocol/live';
import type { Transport } from '../protocol/transport';
import type { State } from '../state';
import { closeDialog, showDialog } from './dialog';
import { find, make } from './dom';
import { othersAgree } from './play';

/** Addresses of the pictures of maps that have come. */
const pictures = new Map<string, string>();

export function offerMaps(state: State, live: Live, transport: Transport): void {
  const { scene } = state;
  if (!scene) return;
  const choices = scene.maps.map(({ name, description }) => {
    const isHere = name === scene.map.name;
    const button = make(
      'button',
      { type: 'button', class: 'choice', 'data-map': name, 'aria-pressed': String(isHere) },
      make('img', { alt: '', width: '128', height: '80' }),
      make('span', {}, make('strong', {}, name), make('small', {}, description)),
    );
    button.onclick = () => {
      closeDialog();
      void changeMap(state, live, name);
    };
    return button;
  });
  if (choices.length === 0)
    choices.push(make('button', { type: 'button', disabled: '' }, 'This server offers no other map.'));
  void showDialog('Maps', make('div', { class: 'choices' }, ...choices));
  find('dialog').querySelector<HTMLElement>('[aria-pressed=true]')?.focus();
  void showPictures(transport);
}

/** Fills the pictures in, one after the other: the server draws each when it is first asked for. */
async function showPictures(transport: Transport): Promise<void> {
  for (const button of find('dialog').querySelectorAll<HTMLElement>('[data-map]')) {
    const { map = '' } = button.dataset;
    try {
      const address = pictures.get(map) ?? URL.createObjectURL(await transport.mapPicture(map));
      pictures.set(map, address);
      button.querySelector('img')!.src = address;
    } catch {
      // It is chosen by its name.
    }
    if (!button.isConnected) return;
  }
}

/** Changes the map, if those whose robots are there agree. */
export async function changeMap(state: State, live: Live, map: string): Promise<void> {
  const agreed = () => othersAgree(state, `Change to ${map}?`, `start again on ${map}`, 'Change the map');
  if (live.refused || (await agreed())) live.control({ map });
}
