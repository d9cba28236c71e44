/** Everything that can be done by name or by key: the palette, the list of keys and the keyboard read this. */

import { ARROWS, isForControl } from './panel/keys';

export interface Action {
  name: string;
  /** `event.key`, and how the key is shown where that differs */
  key?: string;
  shown?: string;
  /** True for an action that needs a server on which robots are driven. */
  drives?: boolean;
  run: () => void;
}

/** Runs those actions that are possible by their keys; `driving` returns whether the space bar and the arrows are not for buttons. */
export function listenToKeys(possible: () => Action[], driving: () => boolean): void {
  window.addEventListener('keydown', (event) => {
    if (document.querySelector('dialog[open]')) return;
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === 'k') {
      event.preventDefault();
      possible()
        .find(({ shown }) => shown === 'Ctrl K')
        ?.run();
      return;
    }
    if (event.ctrlKey || event.metaKey || event.altKey || isForControl(event, driving())) return;
    const action = possible().find(({ key }) => key === event.key);
    if (!action || (ARROWS.includes(event.key) && driving())) return;
    // Else the button that has the focus is pressed, too.
    event.preventDefault();
    if (!event.repeat) action.run();
  });
  // Some browsers press the button that has the focus when the space bar comes up.
  window.addEventListener('keyup', (event) => {
    if (event.key === ' ' && !isForControl(event, driving())) event.preventDefault();
  });
}
