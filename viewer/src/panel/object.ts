/** The chosen object, in the column on the right: its facts, its pose and what can be done with it. */

import { rollPitchYaw } from '../protocol/frame';
import type { Pose } from '../protocol/scene';
import type { State } from '../state';
import { DEGREES } from '../values';
import { find, fixed, make, setText } from './dom';
import type { Hands } from './hands';

export class ObjectPanel {
  private readonly element = make('section', { id: 'object', 'aria-label': 'Object', hidden: '' });
  private readonly name = make('h2', {});
  private readonly facts = make('p', { class: 'facts' });
  private readonly place = make('output', { class: 'facts', 'data-place': '' });
  private readonly copy = make('button', { type: 'button', title: 'Put another one beside it' }, 'Copy');
  private readonly remove = make('button', { type: 'button' }, 'Remove');

  constructor(
    private readonly state: State,
    private readonly hands: Hands,
    uses: { look(object: number): void; remove(): void },
  ) {
    const look = make('button', { type: 'button' }, 'Look at it');
    look.onclick = () => state.chosenObject !== null && uses.look(state.chosenObject);
    this.copy.onclick = () => state.chosenObject !== null && hands.copy(state.chosenObject);
    this.remove.onclick = () => uses.remove();
    const hint = 'Drag it in the view to pull it. Its values in the tree can be plotted.';
    this.element.append(
      this.name,
      this.facts,
      this.place,
      make('div', { class: 'row' }, look, this.copy, this.remove),
      make('p', { class: 'quiet' }, hint),
    );
    find('drive').prepend(this.element);
  }

  /** Shows the chosen object as it is now; to be called a few times a second. */
  update(): void {
    const { chosenObject: number } = this.state;
    const object = number === null ? null : this.state.object(number);
    this.element.hidden = object === null;
    if (!object || number === null) return;
    const { name, mass, material, friction } = object;
    setText(this.name, name);
    const weight = mass === undefined ? '' : `${Number(mass.toPrecision(3))} kg, `;
    setText(this.facts, `${weight}${material}, friction ${friction}`);
    const pose = this.state.objectPose(number);
    setText(this.place, pose ? placeOf(pose) : 'not there');
    this.copy.hidden = !this.hands.mayAct || !this.hands.canCopy(number);
    this.remove.hidden = !this.hands.mayAct;
  }
}

function placeOf(pose: Pose): string {
  const [x, y, z] = pose.map((part) => fixed(part, 3));
  const degrees = rollPitchYaw(pose).map((angle) => fixed(DEGREES * angle, 1));
  return `x ${x}  y ${y}  z ${z} m\nroll ${degrees[0]}°  pitch ${degrees[1]}°  yaw ${degrees[2]}°`;
}
