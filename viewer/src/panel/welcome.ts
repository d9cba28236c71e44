/** Where no robot is: a few to choose from. */

import type { State } from '../state';
import { find, make } from './dom';

/** The robots that are offered, where the server has them, and why. `npm run pictures` makes their pictures. */
const OFFERED = [
  { robotClass: 'YouBotArm', what: 'Mecanum wheels and an arm' },
  { robotClass: 'P3AT', what: 'skid steering and a laser' },
  { robotClass: 'AirRobot', what: 'flies' },
];

export class Welcome {
  private readonly element = find('welcome');
  private shown = '';

  constructor(
    private readonly state: State,
    private readonly spawn: (robotClass: string) => void,
  ) {}

  /** Robots or the scene are others. */
  update(): void {
    const { status, scene, isPresent } = this.state;
    this.element.hidden = !isPresent || !status || status.robots.length > 0;
    const classes = Object.keys(scene?.classes ?? {});
    const known = OFFERED.filter(({ robotClass }) => classes.includes(robotClass));
    const offered = known.length > 0 ? known : classes.slice(0, 3).map((robotClass) => ({ robotClass, what: '' }));
    const shown = JSON.stringify([offered, scene?.port]);
    if (shown === this.shown) return;
    this.shown = shown;
    this.element.replaceChildren(
      make('h2', {}, 'Spawn a robot'),
      make(
        'div',
        { class: 'row' },
        ...offered.map(({ robotClass, what }) => {
          const button = make(
            'button',
            { class: 'card', 'data-spawn': robotClass },
            ...(what ? [make('img', { src: `robots/${robotClass}.png`, alt: '', width: '120', height: '84' })] : []),
            make('strong', {}, robotClass),
            make('small', {}, what),
          );
          button.onclick = () => this.spawn(robotClass);
          return button;
        }),
      ),
      make('p', { class: 'quiet' }, `or connect a controller to port ${scene?.port ?? 3000}`),
    );
  }
}
