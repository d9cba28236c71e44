/** The score board of a league: a card in the view, or the whole page for a hall. */

import type { League } from '../protocol/live';
import type { State } from '../state';
import { teamColour } from '../view/colours';
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

  constructor(private readonly state: State) {
    const name = make('h2', { id: 'board-name' });
    this.element.append(make('header', {}, name, this.time, this.size), this.teams);
    this.size.onclick = () => this.toggle();
    window.addEventListener('hashchange', () => this.resize());
    this.resize();
  }

  /** Shows the league that is played; none hides the board. */
  update(): void {
    // A scenario has a card of its own.
    const league = this.state.scene?.scenario ? null : (this.state.status?.league ?? null);
    this.element.hidden = !league;
    if (!league) return;
    setText(find('board-name'), league.name);
    setText(this.time, league.is_over ? 'time is up' : clock(league.time_left));
    this.element.classList.toggle('waiting', !league.has_begun);
    const teams = league.teams.map((team) => ({ ...team, about: this.about(team) }));
    const shown = JSON.stringify(teams);
    if (shown === this.shown) return;
    this.shown = shown;
    this.teams.replaceChildren(
      ...teams.map(({ place, name, points, about, scores }) => {
        const last = scores.map(({ reason, points }) => make('li', {}, `${signed(points)} ${reason}`));
        const row = make(
          'li',
          { 'data-team': name },
          make('span', { class: 'place' }, String(place)),
          make('span', { class: 'name' }, name),
          make('output', { class: 'points' }, String(points)),
          make('span', { class: 'about' }, about),
          make('ul', { class: 'scores' }, ...last),
        );
        row.style.setProperty('--team', teamColour(name, this.numberOf(name)));
        return row;
      }),
    );
  }

  /** Place of a team in the definition of the league. */
  private numberOf(team: string): number {
    const teams = this.state.scene?.league?.teams ?? [];
    return Math.max(
      0,
      teams.findIndex(({ name }) => name === team),
    );
  }

  /** The robots of a team that are in the world, and the victims that it found. */
  private about({ robots, found }: League['teams'][number]): string {
    const victims = this.state.scene?.league?.victims ?? 0;
    const names = robots.filter((id) => this.state.robot(id)).map((id) => this.state.nameOf(id));
    const ofVictims = victims > 0 ? [`${found} of ${victims} ${victims === 1 ? 'victim' : 'victims'}`] : [];
    return [names.join(', ') || 'no robot', ...ofVictims].join(' · ');
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
