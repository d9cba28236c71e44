/** Cards of a few robots for a world without any. */

import { firstClasses } from '../offer';
import type { State } from '../state';
import { find, make } from './dom';

/** Pictures of classes, by their files. `npm run pictures` makes those of the shipped maps. */
const PICTURES = import.meta.glob<string>('./robots/*.png', { eager: true, query: '?url', import: 'default' });

export class Welcome {
  private readonly element = find('welcome');
  private shown = '';

  constructor(
    private readonly state: State,
    private readonly spawn: (robotClass: string) => void,
    /** Asks for a class, whose description is shown when it has come. */
    private readonly want: (robotClass: string) => void,
  ) {}

  /** Updates the cards after the robots, the scene or its classes changed. */
  update(): void {
    const { status, scene, isPresent } = this.state;
    this.element.hidden = !isPresent || !status || status.robots.length > 0 || scene?.scenario !== null;
    if (!scene) return;
    const offered = firstClasses(scene);
    const described = offered.map((name) => [name, scene.classes[name]?.description ?? '']);
    const shown = JSON.stringify([described, scene.port]);
    if (shown === this.shown) return;
    this.shown = shown;
    offered.forEach(this.want);
    this.element.replaceChildren(
      make('h2', {}, 'Spawn a robot'),
      make(
        'div',
        { class: 'row' },
        ...described.map(([robotClass = '', description = '']) => {
          const picture = PICTURES[`./robots/${robotClass}.png`];
          const button = make(
            'button',
            { class: 'card', 'data-spawn': robotClass },
            ...(picture ? [make('img', { src: picture, alt: '', width: '120', height: '84' })] : []),
            make('strong', {}, robotClass),
            make('small', {}, description),
          );
          button.onclick = () => this.spawn(robotClass);
          return button;
        }),
      ),
      make('p', { class: 'quiet' }, `or connect a controller to port ${scene.port ?? 3000}`),
    );
  }
}
