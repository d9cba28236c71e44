/** The tab for a program: Python that drives the robots of this page, with the line that waits lit. */

import { Orders, type Robots } from '../code/orders';
import type { FromWorker, ToWorker } from '../code/worker';
import cube from '../code/examples/cube.py?raw';
import square from '../code/examples/square.py?raw';
import wall from '../code/examples/wall.py?raw';
import type { Frame } from '../protocol/frame';
import type { State } from '../state';
import './code.css';
import { find, make, remember, remembered, setText } from './dom';

const EXAMPLES = [
  { name: 'A square', program: square },
  { name: 'Follow the wall', program: wall },
  { name: 'Pick the cube', program: cube },
];
/** A program ends that computes for so long without an order, ms. */
const PATIENCE = 10_000;
/** Longest program, letters, and lines of its output that are kept. */
const LONGEST = 50_000;
const KEPT = 500;
const INDENT = '    ';

export class CodePanel {
  private readonly orders: Orders;
  private readonly examples = make('select', { name: 'example', 'aria-label': 'Example' });
  private readonly start = make('button', { type: 'button', id: 'run', class: 'main', title: 'Ctrl Enter' }, 'Run');
  private readonly stop = make('button', { type: 'button', id: 'end-program', disabled: '' }, 'Stop');
  private readonly numbers = make('ol', { class: 'numbers', 'aria-hidden': 'true' });
  private readonly text = make('textarea', {
    name: 'program',
    'aria-label': 'Program in Python',
    'aria-describedby': 'program-keys',
    spellcheck: 'false',
    autocomplete: 'off',
    wrap: 'off',
    maxlength: String(LONGEST),
  });
  private readonly output = make('ol', { id: 'output', role: 'log', 'aria-label': 'Output', tabindex: '0' });
  private readonly status = make('p', { class: 'quiet', role: 'status', 'data-program': '' });
  private worker: Worker | null = null;
  private watch: ReturnType<typeof setTimeout> | undefined;
  /** Orders that are not done. */
  private pending = 0;

  constructor(
    private readonly state: State,
    robots: Robots,
    echo: () => Promise<void>,
  ) {
    this.orders = new Orders(state, robots, echo);
    this.examples.append(
      make('option', { value: '' }, 'Examples'),
      ...EXAMPLES.map(({ name }, index) => make('option', { value: String(index) }, name)),
    );
    this.examples.onchange = () => {
      const example = EXAMPLES[Number(this.examples.value)];
      if (this.examples.value === '' || !example) return;
      this.examples.value = '';
      // As if it were typed, so that the browser can undo it.
      this.text.focus();
      this.text.select();
      this.insert(example.program);
      this.text.setSelectionRange(0, 0);
      this.text.scrollTop = 0;
    };
    this.start.onclick = () => this.run();
    this.stop.onclick = () => this.end('Stopped');
    this.text.value = remembered('program') ?? square;
    this.text.oninput = () => this.changed();
    this.text.onscroll = () => (this.numbers.scrollTop = this.text.scrollTop);
    this.text.onkeydown = (event) => this.key(event);
    find('code').append(
      make('div', { class: 'row' }, this.examples, this.start, this.stop),
      make('div', { class: 'editor' }, this.numbers, this.text),
      make('p', { class: 'quiet', id: 'program-keys' }, 'Ctrl Enter runs it. Esc, then Tab leaves the text.'),
      this.status,
      this.output,
    );
    this.changed();
  }

  /** Takes the newest frame of the server's world. */
  takeFrame(frame: Frame): void {
    // Its times and places are of another world.
    if (this.worker && this.orders.isAnew(frame)) this.end('The world began anew', true);
    this.orders.takeFrame(frame);
  }

  private changed(): void {
    remember('program', this.text.value);
    const count = this.text.value.split('\n').length;
    while (this.numbers.childElementCount < count) this.numbers.append(make('li', {}));
    while (this.numbers.childElementCount > count) this.numbers.lastElementChild?.remove();
  }

  /** Puts a text in place of the selection. */
  private insert(text: string): void {
    // The only way that keeps what can be undone.
    if (!document.execCommand('insertText', false, text)) this.text.setRangeText(text);
    this.changed();
  }

  private key(event: KeyboardEvent): void {
    if (event.key === 'Enter' && event.ctrlKey) this.run();
    else if (event.key === 'Escape') this.start.focus();
    else if (event.key === 'Tab' && !event.shiftKey) this.insert(INDENT);
    else if (event.key === 'Enter') {
      const before = this.text.value.slice(0, this.text.selectionStart).split('\n').at(-1) ?? '';
      const [indent = ''] = /^ */.exec(before) ?? [];
      this.insert(`\n${indent}${before.trimEnd().endsWith(':') ? INDENT : ''}`);
    } else return;
    event.preventDefault();
  }

  private run(): void {
    if (this.worker) this.end('Stopped');
    this.output.replaceChildren();
    this.say('Running', 'running');
    this.worker = new Worker(new URL('../code/worker.ts', import.meta.url), { type: 'module' });
    this.worker.onmessage = ({ data }: MessageEvent<FromWorker>) => this.take(data);
    this.worker.onerror = ({ message }) => this.end(`Python could not be loaded: ${message || 'try again'}`, true);
    this.send({ program: this.text.value });
    this.stop.disabled = false;
    this.state.isProgrammed = true;
    this.expectOrder();
  }

  private take(message: FromWorker): void {
    if ('line' in message) this.light(message.line);
    else if ('printed' in message) this.print(message.printed);
    else if ('ended' in message) this.end(message.ended ?? 'Done', message.ended !== null);
    else void this.answer(message.call, message.name, message.text);
  }

  private async answer(call: number, name: string, text: string): Promise<void> {
    const { worker } = this;
    this.pending++;
    clearTimeout(this.watch);
    let answer: string;
    try {
      if (!this.state.isPresent) throw new Error('the page shows the past: go back to live');
      answer = JSON.stringify({ value: (await this.orders.do(name, JSON.parse(text) as unknown[])) ?? null });
    } catch (error) {
      answer = JSON.stringify({ error: error instanceof Error ? error.message : String(error) });
    }
    // Another program may run by now.
    if (this.worker !== worker) return;
    this.pending--;
    this.send({ answer: call, text: answer });
    if (this.pending === 0) this.expectOrder();
  }

  private send(message: ToWorker): void {
    this.worker?.postMessage(message);
  }

  /** Ends the program if no order comes for a while: its thread would compute for ever. */
  private expectOrder(): void {
    clearTimeout(this.watch);
    const why = `It computed for ${PATIENCE / 1000} s without an order: stopped`;
    this.watch = setTimeout(() => this.end(why, true), PATIENCE);
  }

  private end(why: string, isError = false): void {
    clearTimeout(this.watch);
    this.worker?.terminate();
    this.worker = null;
    this.pending = 0;
    this.stop.disabled = true;
    this.state.isProgrammed = false;
    this.orders.end();
    const line = isError ? Number(/^line (\d+)/.exec(why)?.[1] ?? NaN) : NaN;
    this.light(Number.isNaN(line) ? null : line, isError);
    this.say(why, isError ? 'failed' : 'ended');
  }

  private say(text: string, what: string): void {
    setText(this.status, text);
    this.status.dataset.program = what;
  }

  /** Lights a line; null for none. */
  private light(line: number | null, isError = false): void {
    this.numbers.querySelector('.lit')?.removeAttribute('class');
    const number = line === null ? null : this.numbers.children[line - 1];
    number?.setAttribute('class', isError ? 'lit wrong' : 'lit');
    this.text.style.setProperty('--lit', String(line ?? -1));
    this.text.classList.toggle('wrong', isError);
  }

  private print(text: string): void {
    if (this.output.childElementCount >= KEPT) this.output.firstElementChild?.remove();
    const isAtEnd = this.output.scrollHeight - this.output.scrollTop - this.output.clientHeight < 20;
    this.output.append(make('li', {}, text));
    if (isAtEnd) this.output.scrollTop = this.output.scrollHeight;
  }
}
