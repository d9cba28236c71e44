/** The score board of a league: a card in the view, or the whole page for a hall. */

import type { League } from '../protocol/live';
import { find, make, setText } from './dom';

/** The address that opens the large board. */
const HASH = '#board';

/** Returns seconds as minutes and seconds. */
function clock(seconds: number): string {
  const whole = Math.ceil(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, '0')}`;
}

/** Returns points with their sign. */
const signed = (points: number): string => (points < 0 ? `−${-points}` : `+${points}`);

export class Board {
  private readonly element = find('board');
  private readonly time = make('output', { class: 'time', id: 'board-time' });
  private readonly teams = make('ol', { class: 'teams' });
  private readonly size = make('button', {
    class: 'plain',
    id: 'board-size',
    title: 'The board for a hall, or a card (B)',
  });
  private shown = '';

  constructor() {
    const name = make('h2', { id: 'board-name' });
    this.element.append(make('header', {}, name, this.time, this.size), this.teams);
    this.size.onclick = () => this.toggle();
    window.addEventListener('hashchange', () => this.resize());
    this.resize();
  }

  /** Shows the league of a status; none hides the board. */
  update(league: League | null): void {
    this.element.hidden = !league;
    if (!league) return;
    setText(find('board-name'), league.name);
    setText(this.time, league.is_over ? 'time is up' : clock(league.time_left));
    this.element.classList.toggle('waiting', !league.has_begun);
    const shown = JSON.stringify(league.teams);
    if (shown === this.shown) return;
    this.shown = shown;
    this.teams.replaceChildren(
      ...league.teams.map(({ place, name, points, scores }) => {
        const last = scores.map(({ reason, points }) => make('li', {}, `${signed(points)} ${reason}`));
        return make(
          'li',
          { 'data-team': name },
          make('span', { class: 'place' }, String(place)),
          make('span', { class: 'name' }, name),
          make('output', { class: 'points' }, String(points)),
          make('ul', { class: 'scores' }, ...last),
        );
      }),
    );
  }

  /** Changes between the card and the large board. */
  toggle(): void {
    if (this.element.hidden) return;
    location.hash = location.hash === HASH ? '' : HASH;
  }

  private resize(): void {
    const isLarge = location.hash === HASH;
    this.element.classList.toggle('large', isLarge);
    setText(this.size, isLarge ? 'Show the world' : 'Enlarge');
  }
}
