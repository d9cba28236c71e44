/** Pictures of robots' cameras: a button for each camera and, while it is pressed, the newest picture. */

import type { Picture } from '../protocol/frame';
import type { Camera } from '../protocol/scene';
import type { State } from '../state';
import { fixed, make, setText } from './dom';
import { Inset } from './inset';

export class Pictures {
  /** Pictures by robot and sensor. */
  private readonly rows = new Map<string, PictureRow>();

  /** `wanted` hears the robots whose pictures can be seen now. */
  constructor(
    private readonly state: State,
    private readonly wanted: (robots: number[]) => void,
    /** Changes places: the view looks through the robot's camera, or no longer. */
    private readonly swap: (robot: number) => void,
    /** Returns boxes about the victims in a picture. */
    private readonly boxes: (picture: Picture) => HTMLElement[],
  ) {
    // Timers of a page that is hidden run late.
    document.addEventListener('visibilitychange', () => this.tellWanted());
  }

  /** The rows of a robot's cameras. A camera keeps its row, so that a tree that is built anew has the same picture. */
  of(robot: number): HTMLElement[] {
    const sensors = this.state.classOf(robot)?.sensors ?? [];
    return sensors.flatMap(({ name, camera }, index) => (camera ? [this.row(robot, index, name, camera).element] : []));
  }

  take(picture: Picture): void {
    const row = this.rows.get(key(picture.robot, picture.sensor));
    if (row?.isSeen) row.take(picture, this.boxes(picture));
  }

  /** Forgets robots that have left, and follows the moment that is shown; to be called a few times a second. */
  update(): void {
    for (const [name, row] of this.rows) {
      row.setPresent(this.state.isPresent);
      if (this.state.robot(row.robot)) continue;
      row.hide();
      this.rows.delete(name);
    }
    this.tellWanted();
  }

  /** Hides every picture: it was of another world. */
  end(): void {
    this.rows.forEach((row) => row.hide());
    this.tellWanted();
  }

  private row(robot: number, index: number, name: string, camera: Camera): PictureRow {
    let row = this.rows.get(key(robot, index));
    if (!row?.isOf(name, camera)) {
      row?.hide();
      const uses = { changed: () => this.update(), swap: () => this.swap(robot) };
      row = new PictureRow(robot, index, name, camera, uses);
      this.rows.set(key(robot, index), row);
    }
    row.setOwner(this.state.nameOf(robot));
    return row;
  }

  private tellWanted(): void {
    const isSeen = this.state.isPresent && !document.hidden;
    const robots = [...this.rows.values()].filter((row) => row.isSeen).map(({ robot }) => robot);
    this.wanted(isSeen ? [...new Set(robots)].sort((one, other) => one - other) : []);
  }
}

class PictureRow {
  readonly element: HTMLElement;
  private readonly button: HTMLElement;
  private readonly image = make('img', { hidden: '' });
  private readonly placeholder = make('p', { class: 'quiet' });
  private readonly marks = make('div', { class: 'victim-boxes' });
  private readonly time = make('small');
  private readonly figure: HTMLElement;
  private readonly screen: HTMLElement;
  private url: string | null = null;
  /** Name of the robot. */
  private owner = '';
  private isShown = false;
  private isPresent = true;
  /** False in a folded robot, in a closed panel and where the panel has been scrolled away. */
  private isInView = false;
  /** Its window over the view, while it has one. */
  private inset: Inset | null = null;
  private readonly apart = make('button', { class: 'plain' });
  private readonly observer = new IntersectionObserver((entries) => {
    this.isInView = entries.at(-1)?.isIntersecting ?? false;
    this.uses.changed();
  });

  constructor(
    readonly robot: number,
    index: number,
    private readonly name: string,
    private readonly camera: Camera,
    private readonly uses: { changed(): void; swap(): void },
  ) {
    this.button = make('button', { 'data-camera': key(robot, index) });
    this.button.onclick = () => {
      if (this.isShown) this.hide();
      else this.show();
      uses.changed();
    };
    this.screen = make('div', { class: 'screen' }, this.image, this.marks, this.placeholder);
    // Its room is kept before the first picture, so that nothing jumps.
    this.screen.style.aspectRatio = `${camera.width} / ${camera.height}`;
    this.apart.onclick = () => (this.inset ? this.putBack() : this.putApart());
    const caption = make('figcaption', { class: 'row' }, this.time, this.apart);
    this.figure = make('figure', { hidden: '' }, this.screen, caption);
    const head = make('div', { class: 'row' }, make('span', {}, name), this.button);
    this.element = make('div', { class: 'picture' }, head, this.figure);
    this.hide();
  }

  get isSeen(): boolean {
    return this.isShown && this.isInView;
  }

  isOf(name: string, { width, height }: Camera): boolean {
    return name === this.name && width === this.camera.width && height === this.camera.height;
  }

  setOwner(owner: string): void {
    this.owner = owner;
    this.image.alt = `What ${this.name} of ${owner} sees`;
    this.updateButton();
  }

  setPresent(isPresent: boolean): void {
    if (isPresent === this.isPresent) return;
    this.isPresent = isPresent;
    this.clear();
  }

  take({ time, png }: Picture, boxes: HTMLElement[]): void {
    this.marks.replaceChildren(...boxes);
    const before = this.url;
    this.url = URL.createObjectURL(new Blob([png], { type: 'image/png' }));
    this.image.src = this.url;
    if (before !== null) URL.revokeObjectURL(before);
    [this.image.hidden, this.placeholder.hidden] = [false, true];
    setText(this.time, `Simulated time ${fixed(time, 2)} s`);
  }

  hide(): void {
    this.putBack();
    [this.isShown, this.isInView] = [false, false];
    this.observer.disconnect();
    this.figure.hidden = true;
    this.updateButton();
    this.clear();
  }

  private show(): void {
    this.isShown = true;
    this.figure.hidden = false;
    this.updateButton();
    this.observer.observe(this.screen);
  }

  /** Puts the picture into a window over the view. */
  private putApart(): void {
    const title = `${this.name} of ${this.owner}`;
    this.inset = new Inset(title, this.figure, this.uses.swap, () => this.putBack());
    this.updateButton();
  }

  /** Puts the picture back into its panel. */
  private putBack(): void {
    this.element.append(this.figure);
    this.figure.ondblclick = null;
    this.inset?.remove();
    this.inset = null;
    this.updateButton();
  }

  private updateButton(): void {
    setText(this.apart, this.inset ? 'Put it back' : 'Over the view');
    const action = this.isShown ? 'Hide picture' : 'Show picture';
    setText(this.button, action);
    this.button.setAttribute('aria-pressed', String(this.isShown));
    // Robots have cameras of the same name.
    this.button.setAttribute('aria-label', `${action} of ${this.name} of ${this.owner}`);
  }

  /** Goes back to the placeholder. */
  private clear(): void {
    if (this.url !== null) URL.revokeObjectURL(this.url);
    this.url = null;
    this.image.removeAttribute('src');
    this.marks.replaceChildren();
    [this.image.hidden, this.placeholder.hidden] = [true, false];
    setText(this.placeholder, this.isPresent ? 'Waiting for the first picture' : 'Only the present has pictures');
    setText(this.time, '–');
  }
}

function key(robot: number, sensor: number): string {
  return `${robot}/${sensor}`;
}
