/** The one dialog of the page: questions, lists to choose from, help. Escape closes it. */

import { setToken } from '../protocol/token';
import { find, make } from './dom';

/** Shows something; resolves when it is closed. */
export function showDialog(title: string, ...content: (Node | string)[]): Promise<void> {
  const dialog = find<HTMLDialogElement>('dialog');
  if (dialog.open) dialog.close();
  const close = make('button', { type: 'button', class: 'plain icon', 'aria-label': 'Close' }, '✕');
  close.onclick = () => dialog.close();
  dialog.replaceChildren(
    make('header', {}, make('h2', { id: 'dialog-title' }, title), make('span', { class: 'space' }), close),
    ...content,
  );
  dialog.showModal();
  return new Promise((closed) => dialog.addEventListener('close', () => closed(), { once: true }));
}

export function closeDialog(): void {
  find<HTMLDialogElement>('dialog').close();
}

/** Asks before something that others would notice. */
export async function ask(title: string, question: string, answer: string): Promise<boolean> {
  let agreed = false;
  const yes = make('button', { type: 'button', class: 'main' }, answer);
  const no = make('button', { type: 'button' }, 'Cancel');
  yes.onclick = () => {
    agreed = true;
    closeDialog();
  };
  no.onclick = () => closeDialog();
  const closed = showDialog(title, make('p', {}, question), make('div', { class: 'row end' }, no, yes));
  no.focus();
  await closed;
  return agreed;
}

/** Asks for the token of the server, and keeps it. */
export async function askToken(hadToken: boolean): Promise<void> {
  const input = make('input', { id: 'token', type: 'password', autocomplete: 'current-password', required: '' });
  const form = make(
    'form',
    { class: 'row' },
    make('label', { for: 'token' }, 'Token'),
    input,
    make('button', { class: 'main' }, 'Log in'),
  );
  form.onsubmit = (event) => {
    event.preventDefault();
    setToken(input.value);
    closeDialog();
  };
  const why = hadToken
    ? 'The server does not accept this token for watching. Whoever started it has another one for you.'
    : 'This server shows its world to those who have a token. Whoever started it has one for you.';
  const closed = showDialog('A token, please', make('p', {}, why), form);
  input.focus();
  await closed;
}
