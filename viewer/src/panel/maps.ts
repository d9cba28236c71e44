/** The dialog to choose a map. */

import type { Live } from '../protocol/live';
import type { State } from '../state';
import { closeDialog, showDialog } from './dialog';
import { find, make } from './dom';
import { othersAgree } from './play';

export function offerMaps(state: State, live: Live): void {
  const { scene } = state;
  if (!scene) return;
  const choices = scene.maps.map(({ name, description }) => {
    const isHere = name === scene.map.name;
    const button = make(
      'button',
      { type: 'button', class: 'choice', 'data-map': name, 'aria-pressed': String(isHere) },
      make('strong', {}, name),
      make('small', {}, description),
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
}

/** Changes the map, if those whose robots are there agree. */
export async function changeMap(state: State, live: Live, map: string): Promise<void> {
  const agreed = () => othersAgree(state, `Change to ${map}?`, `start again on ${map}`, 'Change the map');
  if (live.refused || (await agreed())) live.control({ map });
}
