/** Receiver of a key: the control with the focus, or the robot and the world. */

import { find } from './dom';

export const ARROWS = ['ArrowUp', 'ArrowDown', 'ArrowLeft', 'ArrowRight'];

/** True if the control with the focus needs a key for itself. While a robot is driven, buttons do not get space. */
export function isForControl({ key, target, defaultPrevented }: KeyboardEvent, driving: boolean): boolean {
  if (defaultPrevented) return true;
  if (!(target instanceof HTMLElement)) return false;
  // One that has just been closed may have the focus for a moment.
  const dialog = target.closest('dialog');
  if (dialog) return dialog.open;
  if (target.matches('input[type=range]')) return ARROWS.includes(key);
  if (target.matches('select')) return key === ' ' || ARROWS.includes(key);
  if (target.matches('input[type=checkbox]')) return key === ' ';
  if (target.matches('button, summary')) return key === ' ' && !driving;
  return target.matches('input, textarea');
}

/** Gives the keys to the robot and the world. */
export function focusView(): void {
  find('canvas').focus({ preventScroll: true });
}

/** A choice made by mouse or finger is done with; by keyboard one may still be on the way to another. */
export function returnFocusAfterChoice(): void {
  let byPointer = false;
  document.addEventListener('pointerdown', () => (byPointer = true), true);
  document.addEventListener('keydown', () => (byPointer = false), true);
  document.addEventListener('change', ({ target }) => {
    if (byPointer && target instanceof HTMLElement && target.matches('select, input[type=checkbox]')) focusView();
  });
}
