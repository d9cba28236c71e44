/** Menu of what can be done with a robot, an object or a place of the floor. */

import type { Vector } from '../protocol/scene';
import type { State } from '../state';
import type { CameraMode, Hit, View } from '../view/view';
import { find } from './dom';
import { type Hands, OBJECTS, type Thing } from './hands';
import { type Item, showMenu } from './menu';

/** Uses of the menu's items. */
interface Uses {
  choose(thing: Thing): void;
  look(mode: CameraMode): void;
  spawnAt(place: Vector): void;
  /** Spawns another robot of the chosen one's class beside it. */
  copyRobot(): void;
  /** Removes what is chosen. */
  remove(): void;
}

export class ContextMenu {
  constructor(
    private readonly state: State,
    private readonly view: View,
    private readonly hands: Hands,
    private readonly uses: Uses,
  ) {}

  /** Opens it for what is at a point of the screen. */
  open(hit: Hit, x: number, y: number): void {
    if ('ground' in hit) {
      const items = this.hands.mayAct ? this.ofFloor(hit.place) : [];
      if (items.length > 0) showMenu('Here', items, x, y);
      return;
    }
    this.uses.choose(hit);
    const name = 'robot' in hit ? this.state.nameOf(hit.robot) : (this.state.object(hit.object)?.name ?? '');
    showMenu(name, [...('robot' in hit ? this.ofRobot() : this.ofObject(hit.object)), ...this.removal], x, y);
  }

  /** Opens it for what is chosen, in the middle of the view. */
  openOfChosen(): void {
    const { chosen } = this.hands;
    const [x, y] = middle();
    if (chosen) this.open({ link: null, ...chosen, place: [0, 0, 0] }, x, y);
    else this.openOfMiddle();
  }

  /** Opens it for the floor in the middle of the view. */
  openOfMiddle(): void {
    const [x, y] = middle();
    const place = this.view.groundAt(x, y);
    if (place) this.open({ ground: true, place }, x, y);
  }

  private get removal(): Item[] {
    return this.hands.mayAct ? [{ name: 'Remove', run: () => this.uses.remove() }] : [];
  }

  private ofRobot(): Item[] {
    return [
      { name: 'Follow it', run: () => this.uses.look('follow') },
      { name: 'Look from here', run: () => this.uses.look('robot') },
      { name: 'Show it as large as there is room', run: () => this.view.fit(this.state.selected) },
      ...(this.hands.mayAct ? [{ name: 'Copy', run: () => this.uses.copyRobot() }] : []),
    ];
  }

  private ofObject(object: number): Item[] {
    const copy = { name: 'Copy', run: () => this.hands.copy(object) };
    const copies = this.hands.mayAct && this.hands.canCopy(object) ? [copy] : [];
    return [{ name: 'Look at it', run: () => this.view.lookAtObject(object) }, ...copies];
  }

  private ofFloor(place: Vector): Item[] {
    const put = OBJECTS.map(({ name, objectClass, height }) => {
      return { name: `Put ${name} here`, run: () => this.hands.put(objectClass, height, place) };
    });
    return [{ name: 'Spawn a robot here', run: () => this.uses.spawnAt(place) }, ...put];
  }
}

function middle(): [number, number] {
  const { left, top, width, height } = find('canvas').getBoundingClientRect();
  return [left + width / 2, top + height / 2];
}
