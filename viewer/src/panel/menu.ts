/** A menu at a point of the page. Arrows go through it, and Escape closes it. */

import { make } from './dom';
import './menu.css';

export interface Item {
  name: string;
  run: () => void;
}

let close: (() => void) | null = null;

export function showMenu(title: string, items: readonly Item[], x: number, y: number): void {
  close?.();
  const before = document.activeElement;
  const buttons = items.map(({ name, run }) => {
    const button = make('button', { type: 'button', role: 'menuitem' }, name);
    button.onclick = () => {
      close?.();
      run();
    };
    return button;
  });
  const menu = make('div', { id: 'menu', role: 'menu', 'aria-label': title }, make('small', {}, title), ...buttons);
  const outside = ({ target }: PointerEvent) => target instanceof Node && !menu.contains(target) && close?.();
  close = () => {
    close = null;
    document.removeEventListener('pointerdown', outside, true);
    menu.remove();
    if (before instanceof HTMLElement) before.focus();
  };
  menu.onkeydown = (event) => {
    const at = buttons.indexOf(document.activeElement as HTMLButtonElement);
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const [isEnd, isPress] = [
      ['Escape', 'Tab'],
      ['Enter', ' '],
    ].map((keys) => keys.includes(event.key));
    if (!step && !isEnd && !isPress) return;
    // Keys of the menu neither drive nor press what is behind it.
    event.stopPropagation();
    if (!isPress) event.preventDefault();
    if (step) buttons[(at + step + buttons.length) % buttons.length]?.focus();
    if (isEnd) close?.();
  };
  document.addEventListener('pointerdown', outside, true);
  document.body.append(menu);
  menu.style.left = `${Math.max(4, Math.min(x, innerWidth - menu.offsetWidth - 4))}px`;
  menu.style.top = `${Math.max(4, Math.min(y, innerHeight - menu.offsetHeight - 4))}px`;
  buttons[0]?.focus();
}
