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

/** Edges of panels that can be dragged, or moved by arrow keys; sizes stay from visit to visit. */
export function buildSplitters(): void {
  for (const splitter of document.querySelectorAll<HTMLElement>('.splitter')) {
    const pane = find(splitter.dataset.resizes ?? '');
    const edge = splitter.dataset.edge ?? 'right';
    const vertical = edge === 'top';
    const resize = (size: number) => {
      const fitting = Math.round(Math.max(SIZES.least, Math.min(SIZES.most, size)));
      pane.style.setProperty('--size', `${fitting}px`);
      splitter.setAttribute('aria-valuenow', String(fitting));
      remember(`size.${pane.id}`, String(fitting));
    };
    const size = () => (vertical ? pane.offsetHeight : pane.offsetWidth);
    const attributes = {
      role: 'separator',
      tabindex: '0',
      'aria-orientation': vertical ? 'horizontal' : 'vertical',
      'aria-label': `Size of ${pane.getAttribute('aria-label')}`,
      'aria-valuemin': String(SIZES.least),
      'aria-valuemax': String(SIZES.most),
      'aria-valuenow': String(remembered(`size.${pane.id}`) ?? 260),
    };
    Object.entries(attributes).forEach(([name, value]) => splitter.setAttribute(name, value));
    const kept = Number(remembered(`size.${pane.id}`));
    if (kept > 0) resize(kept);
    splitter.onpointerdown = (event) => {
      splitter.setPointerCapture(event.pointerId);
      event.preventDefault();
    };
    splitter.onpointermove = (event) => {
      if (!splitter.hasPointerCapture(event.pointerId)) return;
      const { left, right, bottom } = pane.getBoundingClientRect();
      resize(
        edge === 'right' ? event.clientX - left : edge === 'left' ? right - event.clientX : bottom - event.clientY,
      );
    };
    splitter.onkeydown = (event) => {
      const grows = edge === 'right' ? 'ArrowRight' : edge === 'left' ? 'ArrowLeft' : 'ArrowUp';
      const shrinks = edge === 'right' ? 'ArrowLeft' : edge === 'left' ? 'ArrowRight' : 'ArrowDown';
      if (event.key !== grows && event.key !== shrinks) return;
      event.preventDefault();
      resize(size() + (event.key === grows ? SIZES.step : -SIZES.step));
    };
  }
}
