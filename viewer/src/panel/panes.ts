/** Columns, tabs and, on a phone, sheets: which are shown and how large they are. */

import { find, remember, remembered } from './dom';

/** Least and most size of a column, px, and how far an arrow key moves its edge. */
const SIZES = { least: 180, most: 640, step: 20 };

/** Shows a tab of the right column; `shown` hears which one. */
export function buildTabs(shown: (tab: string) => void): (tab: string) => void {
  const tabs = [...document.querySelectorAll<HTMLElement>('[role=tab]')];
  const show = (name: string) => {
    for (const tab of tabs) {
      const chosen = tab.dataset.tab === name;
      tab.setAttribute('aria-selected', String(chosen));
      tab.tabIndex = chosen ? 0 : -1;
      find(tab.dataset.tab ?? '').hidden = !chosen;
    }
    shown(name);
  };
  tabs.forEach((tab, index) => {
    tab.onclick = () => show(tab.dataset.tab ?? '');
    tab.onkeydown = (event) => {
      const { key } = event;
      if (key !== 'ArrowLeft' && key !== 'ArrowRight') return;
      event.preventDefault();
      const next = tabs[(index + (key === 'ArrowRight' ? 1 : tabs.length - 1)) % tabs.length];
      next?.focus();
      next?.click();
    };
  });
  return show;
}

/** Builds the sheets of a phone: one panel at a time lies over the view, or none. */
export function buildSheets(
  showTab: (tab: string) => void,
  showPlots: (shown: boolean) => void,
): (sheet: string | null) => void {
  const buttons = [...document.querySelectorAll<HTMLElement>('[data-sheet]')];
  const show = (sheet: string | null) => {
    document.body.dataset.sheet = sheet ?? '';
    buttons.forEach((button) => button.setAttribute('aria-pressed', String(button.dataset.sheet === sheet)));
    if (sheet === 'drive' || sheet === 'wire' || sheet === 'code') showTab(sheet);
    if (matchMedia('(max-width: 760px)').matches) showPlots(sheet === 'plots');
  };
  buttons.forEach((button) => {
    button.onclick = () =>
      show(document.body.dataset.sheet === button.dataset.sheet ? null : (button.dataset.sheet ?? null));
  });
  show(null);
  return show;
}

/** Screens on which plots stand beside the view, as style.css has it. */
export const WIDE = matchMedia('(min-width: 1700px)');

/** Edges of panels that can be dragged, or moved by arrow keys; sizes stay from visit to visit. */
export function buildSplitters(): void {
  for (const splitter of document.querySelectorAll<HTMLElement>('.splitter')) {
    const pane = find(splitter.dataset.resizes ?? '');
    const isBelow = splitter.dataset.edge === 'top';
    const edge = () => (isBelow && WIDE.matches ? 'left' : (splitter.dataset.edge ?? 'right'));
    // What stands below on one screen and beside on another has a height and a width.
    const property = () => (isBelow && WIDE.matches ? '--wide' : '--size');
    const key = () => `${property() === '--wide' ? 'width' : 'size'}.${pane.id}`;
    const resize = (size: number) => {
      const fitting = Math.round(Math.max(SIZES.least, Math.min(SIZES.most, size)));
      pane.style.setProperty(property(), `${fitting}px`);
      splitter.setAttribute('aria-valuenow', String(fitting));
      remember(key(), String(fitting));
    };
    const size = () => (edge() === 'top' ? pane.offsetHeight : pane.offsetWidth);
    const describe = () => {
      const kept = Number(remembered(key()));
      const attributes = {
        role: 'separator',
        tabindex: '0',
        'aria-orientation': edge() === 'top' ? 'horizontal' : 'vertical',
        'aria-label': `Size of ${pane.getAttribute('aria-label')}`,
        'aria-valuemin': String(SIZES.least),
        'aria-valuemax': String(SIZES.most),
        'aria-valuenow': String(kept || 260),
      };
      Object.entries(attributes).forEach(([name, value]) => splitter.setAttribute(name, value));
      if (kept > 0) resize(kept);
    };
    describe();
    WIDE.addEventListener('change', describe);
    splitter.onpointerdown = (event) => {
      splitter.setPointerCapture(event.pointerId);
      event.preventDefault();
    };
    splitter.onpointermove = (event) => {
      if (!splitter.hasPointerCapture(event.pointerId)) return;
      const { left, right, bottom } = pane.getBoundingClientRect();
      const { clientX: x, clientY: y } = event;
      resize(edge() === 'right' ? x - left : edge() === 'left' ? right - x : bottom - y);
    };
    splitter.onkeydown = (event) => {
      const grows = edge() === 'right' ? 'ArrowRight' : edge() === 'left' ? 'ArrowLeft' : 'ArrowUp';
      const shrinks = edge() === 'right' ? 'ArrowLeft' : edge() === 'left' ? 'ArrowRight' : 'ArrowDown';
      if (event.key !== grows && event.key !== shrinks) return;
      event.preventDefault();
      resize(size() + (event.key === grows ? SIZES.step : -SIZES.step));
    };
  }
}

/** In a frame of another page, as in a notebook, the view has the room until the panels are wanted. */
export function buildFrame(): void {
  const { documentElement: page } = document;
  page.toggleAttribute('data-framed', window.self !== window.top);
  find('panels').onclick = () => {
    find('panels').setAttribute('aria-pressed', String(page.toggleAttribute('data-panels')));
  };
}
