/** A program in Python, in a thread of its own: MicroPython, which knows the robots of `robots.py`. */

import { loadMicroPython } from '@micropython/micropython-webassembly-pyscript/micropython.mjs';
import interpreter from '@micropython/micropython-webassembly-pyscript/micropython.wasm?url';
import { markWaiting, plainError } from './lines';
import robots from './robots.py?raw';

/** Text from the page: a program to run, or the answer to a call. */
export type ToWorker = { program: string } | { answer: number; text: string };
/** Text to the page: the line that waits, a call of an order, a printed line, or the end of the program with its error. */
export type FromWorker =
  { line: number } | { call: number; name: string; text: string } | { printed: string } | { ended: string | null };

/** Memory of a program, bytes. */
const MEMORY = 8 * 1024 * 1024;
/** Lines that it prints between two orders, and letters of a line, at most. */
const MOST_PRINTED = 1000;
const LONGEST_LINE = 2000;
/** Names of `robots.py` that a program has. */
const NAMES = ['Robot', 'take', 'wait', 'now'];

const post = (message: FromWorker) => self.postMessage(message);
const waiting = new Map<number, (text: string) => void>();
let calls = 0;
let printed = 0;

self.onmessage = ({ data }: MessageEvent<ToWorker>) => {
  if ('program' in data) void run(data.program);
  else {
    waiting.get(data.answer)?.(data.text);
    waiting.delete(data.answer);
  }
};

async function run(program: string): Promise<void> {
  const python = await loadMicroPython({
    url: interpreter,
    heapsize: MEMORY,
    stdout: print,
    stderr: print,
    linebuffer: true,
  });
  python.registerJsModule('_page', {
    at: (line: number) => post({ line }),
    call: (name: string, text: string) =>
      new Promise<string>((resolve) => {
        printed = 0;
        waiting.set(++calls, resolve);
        post({ call: calls, name, text });
      }),
    robots,
  });
  try {
    // As a module of its own it leaves the program's lines their numbers.
    python.runPython(
      `import _page, sys\n_all = {"__name__": "robots"}\nexec(_page.robots, _all)\n` +
        NAMES.map((name) => `${name} = _all["${name}"]\n`).join(''),
    );
    await python.runPythonAsync(markWaiting(program));
    post({ ended: null });
  } catch (error) {
    post({ ended: plainError(error instanceof Error ? error.message : String(error)) });
  }
}

function print(line: string): void {
  if (++printed === MOST_PRINTED) post({ ended: `printed ${MOST_PRINTED} lines without an order between them` });
  if (printed < MOST_PRINTED) post({ printed: line.slice(0, LONGEST_LINE) });
}
