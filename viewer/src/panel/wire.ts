/** The tab of the wire's raw lines, and of what the server says; and a line of one's own. */

import type { WireLine } from '../protocol/live';
import { find, make } from './dom';

/** Lines that are kept, and most that are shown at a time. */
const KEPT = 5000;
const SHOWN = 150;
/** Characters of a line that are shown; a click shows the rest. */
const SHORT = 220;
/** Least time between two updates of the list, ms. */
const INTERVAL = 400;

type Entry = WireLine | { said: string };

export class WirePanel {
  private readonly own = make('input', {
    name: 'line',
    list: 'suggested-lines',
    autocomplete: 'off',
    spellcheck: 'false',
    placeholder: 'DRIVE {Left 2} {Right 2}',
    title: "A line of the protocol, sent as the driven robot's client; ↑ brings earlier ones back",
  });
  private readonly suggested = make('datalist', { id: 'suggested-lines' });
  /** Lines that were sent, and the place of the one that is shown again, from the end. */
  private readonly sent: string[] = [];
  private back = 0;
  private readonly text = make('input', { name: 'filter' });
  private readonly direction = make('select', { name: 'direction' });
  private readonly connection = make('input', {
    name: 'connection',
    size: '5',
    inputmode: 'numeric',
    title: 'Number of a client, as the tree lists it; empty for all',
  });
  private readonly hold = make('button', { type: 'button', 'aria-pressed': 'false' }, 'Hold');
  private readonly list = make('ol', { id: 'lines' });
  private readonly entries: Entry[] = [];
  private readonly element = find('wire');
  private stale = true;
  private drawn = 0;

  /** `say` sends a line. `suggestions` has examples for the robot that is driven now. */
  constructor(
    private readonly say: (line: string) => void,
    suggestions: () => string[],
  ) {
    const form = make(
      'form',
      { class: 'row' },
      make('label', {}, 'Line', this.own),
      make('button', {}, 'Send'),
      this.suggested,
    );
    form.onsubmit = (event) => {
      event.preventDefault();
      this.send();
    };
    this.own.onfocus = () => this.suggested.replaceChildren(...suggestions().map((value) => make('option', { value })));
    this.own.onkeydown = (event) => this.recall(event);
    for (const [value, name] of [
      ['', 'all'],
      ['in', 'from the client'],
      ['out', 'to the client'],
    ] as const) {
      this.direction.append(make('option', { value }, name));
    }
    const clear = make('button', { type: 'button' }, 'Clear');
    clear.onclick = () => {
      this.entries.length = 0;
      this.stale = true;
    };
    this.hold.onclick = () => {
      this.hold.setAttribute('aria-pressed', String(!this.isHeld()));
      this.stale = true;
    };
    [this.text, this.direction, this.connection].forEach((field) => (field.oninput = () => (this.stale = true)));
    this.element.append(
      form,
      make(
        'div',
        { class: 'row' },
        make('label', {}, 'Filter', this.text),
        make('label', {}, 'Lines', this.direction),
        make('label', {}, 'Client', this.connection),
        this.hold,
        clear,
      ),
      this.list,
    );
  }

  line(line: WireLine): void {
    this.add(line);
  }

  said(said: string): void {
    this.add({ said });
  }

  /** Shows what has come, newest first; to be called a few times a second. */
  draw(): void {
    const now = performance.now();
    if (this.element.hidden || !this.stale || this.isHeld() || now - this.drawn < INTERVAL) return;
    this.stale = false;
    this.drawn = now;
    const shown = this.entries.filter((entry) => this.fits(entry)).slice(-SHOWN);
    this.list.replaceChildren(...shown.reverse().map(item));
  }

  private send(): void {
    const line = this.own.value.trim();
    if (line === '') return;
    this.say(line);
    this.sent.push(line);
    this.back = 0;
    this.own.value = '';
  }

  /** Brings lines that were sent back with the arrow keys, as a shell does. */
  private recall(event: KeyboardEvent): void {
    const step = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    // With text of one's own the arrows choose among suggestions.
    if (step === undefined || (this.back === 0 && this.own.value !== '')) return;
    const back = Math.min(this.sent.length, Math.max(0, this.back + step));
    if (back === this.back) return;
    event.preventDefault();
    this.back = back;
    this.own.value = back === 0 ? '' : (this.sent.at(-back) ?? '');
  }

  private add(entry: Entry): void {
    this.entries.push(entry);
    if (this.entries.length > KEPT) this.entries.splice(0, KEPT / 5);
    this.stale = true;
  }

  private isHeld(): boolean {
    return this.hold.getAttribute('aria-pressed') === 'true';
  }

  private fits(entry: Entry): boolean {
    const [text, direction, connection] = [this.text.value.toLowerCase(), this.direction.value, this.connection.value];
    if ('said' in entry) return entry.said.toLowerCase().includes(text) && !direction && !connection;
    return (
      entry.text.toLowerCase().includes(text) &&
      (!direction || entry.direction === direction) &&
      (!connection.trim() || String(entry.connection) === connection.trim())
    );
  }
}

function item(entry: Entry): HTMLElement {
  if ('said' in entry) return make('li', { class: 'said' }, entry.said);
  const { time, direction, connection, text } = entry;
  const head = `${time.toFixed(3)} ${direction === 'in' ? '→' : '←'}${connection} `;
  const element = make('li', { class: direction }, head + (text.length > SHORT ? `${text.slice(0, SHORT)} …` : text));
  element.onclick = () => (element.textContent = head + text);
  return element;
}
