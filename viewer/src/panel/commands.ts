/** The two lists of everything that can be done: by name, and by key. */

import type { Action } from '../actions';
import { DRIVING_KEYS } from './drive';
import { closeDialog, showDialog } from './dialog';
import { make } from './dom';

/** A box to type a part of a name in; Enter runs the first that fits. */
export function showCommands(actions: Action[]): void {
  const input = make('input', { type: 'search', 'aria-label': 'Command', placeholder: 'Type a part of its name' });
  const list = make('div', { class: 'choices', id: 'command-list' });
  const fill = () => {
    const words = input.value.toLowerCase().split(/\s+/);
    const fitting = actions.filter(({ name }) => words.every((word) => name.toLowerCase().includes(word)));
    list.replaceChildren(
      ...fitting.map((action) => {
        const button = make('button', { type: 'button', class: 'choice' }, action.name, ...shownKey(action));
        button.onclick = () => {
          closeDialog();
          action.run();
        };
        return button;
      }),
    );
    if (fitting.length === 0) list.append(make('p', { class: 'quiet' }, 'No command has these words.'));
  };
  input.oninput = fill;
  input.onkeydown = (event) => {
    if (event.key === 'Enter') {
      // Else it also presses what the command moves the focus to.
      event.preventDefault();
      list.querySelector('button')?.click();
    }
    if (event.key === 'ArrowDown') list.querySelector('button')?.focus();
  };
  fill();
  void showDialog('Commands', input, list);
  input.focus();
}

export function showKeys(actions: Action[]): void {
  const row = (keys: string[], what: string) =>
    make('tr', {}, make('td', {}, ...keys.flatMap((key) => [make('kbd', {}, key), ' '])), make('td', {}, what));
  const driving = DRIVING_KEYS.map(({ keys, what }) => row(keys, what));
  const world = actions
    .filter(({ key, shown }) => key ?? shown)
    .map(({ key = '', shown, name }) => row([shown ?? key], name));
  void showDialog(
    'Keys',
    make(
      'div',
      { class: 'columns' },
      make('table', {}, head('While a robot is driven'), ...driving),
      make('table', {}, head('Always'), ...world),
    ),
    make(
      'p',
      { class: 'quiet' },
      'Drag turns the view, right drag or two fingers move it, the wheel zooms. A drag on the chosen robot or object pulls it: Shift lifts, Ctrl turns. A right click has more. A gamepad drives: left stick moves, right stick turns, triggers go up and down.',
    ),
  );
}

function head(text: string): HTMLElement {
  return make('tr', {}, make('th', { colspan: '2', scope: 'colgroup' }, text));
}

function shownKey({ key, shown }: Action): HTMLElement[] {
  const text = shown ?? key;
  return text ? [make('kbd', {}, text)] : [];
}
