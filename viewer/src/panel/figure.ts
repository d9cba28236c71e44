/** Parts that all plots have: a caption with two buttons, and numbers of an axis. */

import { make, save } from './dom';

/** Returns the caption of a plot: its title, and buttons that save it as a PNG and close it. `what` names it for those who do not see it. */
export function caption(
  title: HTMLElement,
  what: string,
  canvas: () => HTMLCanvasElement | undefined,
  close: () => void,
): HTMLElement {
  const picture = make(
    'button',
    { type: 'button', class: 'plain icon', title: 'Save as PNG', 'aria-label': `Save the plot of ${what} as PNG` },
    '⤓',
  );
  picture.onclick = () => canvas()?.toBlob((blob) => blob && save(blob, 'usarsim-plot.png'));
  const cross = make('button', { type: 'button', class: 'plain icon', 'aria-label': `Close the plot of ${what}` }, '✕');
  cross.onclick = close;
  return make('figcaption', {}, title, make('span', { class: 'space' }), picture, cross);
}

/** Returns the digits after the point that tell numbers apart which differ by a step. */
export function digitsOf(step: number): number {
  return Math.max(0, Math.min(6, Math.ceil(-Math.log10(step) - 1e-9)));
}
