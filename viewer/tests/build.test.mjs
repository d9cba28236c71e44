// `make view` in a copy of what it needs: the server is linked anew whenever viewer/dist is touched.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import {
  appendFileSync,
  cpSync,
  mkdirSync,
  mkdtempSync,
  readFileSync,
  readdirSync,
  rmSync,
  statSync,
  symlinkSync,
  utimesSync,
  writeFileSync,
} from 'node:fs';
import { tmpdir } from 'node:os';
import { delimiter, join } from 'node:path';
import { after, before, test } from 'node:test';
import { root } from './server.mjs';

const folder = mkdtempSync(join(tmpdir(), 'usarsim-build-'));
const viewer = join(folder, 'viewer');
const main = join(viewer, 'src/main.ts');
const added = join(viewer, 'public/added.txt');

before(() => {
  mkdirSync(join(viewer, 'dist'), { recursive: true });
  for (const name of ['Makefile', ...readdirSync(join(root, 'viewer')).map((name) => `viewer/${name}`)]) {
    if (name === 'viewer/node_modules') symlinkSync(join(root, name), join(folder, name));
    else if (name !== 'viewer/dist') {
      cpSync(join(root, name), join(folder, name), { recursive: true, preserveTimestamps: true });
    }
  }
});

after(() => rmSync(folder, { recursive: true }));

function make(target, PATH = process.env.PATH) {
  return execFileSync('make', [target], { cwd: folder, env: { ...process.env, PATH }, stdio: 'pipe' }).toString();
}

/** Every file of the built page with its text and, as a number, when it was written. */
function built() {
  const page = join(viewer, 'dist/page');
  return readdirSync(page, { recursive: true })
    .map((name) => join(page, name))
    .filter((path) => statSync(path).isFile())
    .map((path) => ({ path, text: readFileSync(path, 'latin1'), written: statSync(path).mtimeMs }));
}

const texts = () => built().map(({ path, text }) => ({ path, text }));
const holds = (text) => built().some((file) => file.text.includes(text));

test('a page that is the same is not written again', () => {
  make('view');
  const first = built();
  assert.ok(first.length >= 4, `${first.length} files`);
  assert.doesNotMatch(make('view'), /vite/);
  assert.deepEqual(built(), first);
  // As a change of branches forth and back leaves it.
  utimesSync(main, new Date(), new Date());
  assert.match(make('view'), /vite/);
  assert.deepEqual(built(), first);
});

test('a change of the sources changes the page', () => {
  const [first, text] = [texts(), readFileSync(main)];
  appendFileSync(main, '\nwindow.name = "a line more";\n');
  make('view');
  assert.ok(holds('a line more'));
  writeFileSync(main, text);
  make('view');
  assert.deepEqual(texts(), first);
  writeFileSync(added, 'an added file');
  make('view');
  assert.ok(holds('an added file'));
  rmSync(added);
  make('view');
  assert.deepEqual(texts(), first);
});

test('a page that was removed comes back', () => {
  const first = texts();
  rmSync(join(viewer, 'dist/page'), { recursive: true });
  make('view');
  assert.deepEqual(texts(), first);
});

test('without npm one line says what can be done without it', () => {
  const tools = join(folder, 'tools');
  mkdirSync(tools);
  const find = (name) =>
    process.env.PATH.split(delimiter)
      .map((part) => join(part, name))
      .find((path) => statSync(path, { throwIfNoEntry: false }));
  for (const name of ['make', 'find', 'sh', 'diff', 'cp', 'rm']) symlinkSync(find(name), join(tools, name));
  rmSync(join(folder, 'target'), { recursive: true });
  assert.throws(
    () => make('run', tools),
    ({ stderr }) => {
      assert.match(
        stderr.toString(),
        /^Makefile:\d+: \*\*\* npm is missing.*`cargo run --release -- serve` does all but the page\. {2}Stop\.\n$/,
      );
      return true;
    },
  );
});
