// Classes of robots, which the page asks for when it needs them.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { join } from 'node:path';
import { runnerImport } from 'vite';
import { settled, standInForBrowser } from './messages.mjs';
import { root } from './server.mjs';

const module = async (name) => (await runnerImport(join(root, `viewer/src/protocol/${name}.ts`))).module;
const { ClassQuestions } = await module('classes');
const { network } = await module('network');

const sceneOf = (...names) => ({ names, classes: {} });

/** Questions to a server that answers when the test says so. */
function server(context) {
  standInForBrowser();
  const asked = [];
  context.mock.method(globalThis, 'fetch', (name) => {
    return new Promise((resolve, reject) =>
      asked.push({ name, reject, answer: (description) => resolve(Response.json({ description })) }),
    );
  });
  const came = [];
  return { asked, came, questions: new ClassQuestions(() => came.push('came'), network.robotClass) };
}

test('a class is asked for once, and is in the scene when everyone hears of it', async (context) => {
  const { asked, came, questions } = server(context);
  assert.equal(await questions.want('Cart'), null);
  const scene = sceneOf('Cart', 'a/b');
  questions.restart(scene);
  const wants = ['Cart', 'Cart', 'a/b'].map((name) => questions.want(name));
  assert.deepEqual(
    asked.map(({ name }) => name),
    ['class/Cart', 'class/a%2Fb'],
  );
  asked[0].answer('a cart');
  assert.deepEqual(await Promise.all(wants.slice(0, 2)), [{ description: 'a cart' }, { description: 'a cart' }]);
  assert.deepEqual([scene.classes, came.length], [{ Cart: { description: 'a cart' } }, 1]);
  assert.deepEqual(await questions.want('Cart'), { description: 'a cart' });
  assert.equal(asked.length, 2);
});

test('a class that came while the server runs is asked for, and its name is known then', async (context) => {
  const { asked, questions } = server(context);
  const scene = sceneOf('Cart');
  questions.restart(scene);
  const dropped = questions.want('Dropped');
  asked[0].answer('a robot of a file');
  assert.deepEqual(await dropped, { description: 'a robot of a file' });
  assert.deepEqual(scene.names, ['Cart', 'Dropped']);
  const nobody = questions.want('Nobody');
  asked[1].reject(new Error('there is none'));
  assert.equal(await nobody, null);
  assert.deepEqual(scene.names, ['Cart', 'Dropped']);
});

test('a class that did not come is asked for again', async (context) => {
  const { asked, came, questions } = server(context);
  questions.restart(sceneOf('Cart'));
  const first = questions.want('Cart');
  asked[0].reject(new Error('gone'));
  assert.deepEqual([await first, came.length], [null, 0]);
  const second = questions.want('Cart');
  asked[1].answer('a cart');
  assert.deepEqual([await second, came.length], [{ description: 'a cart' }, 1]);
});

test('another map keeps the classes, and another server has none of them', async (context) => {
  const { asked, came, questions } = server(context);
  questions.restart(sceneOf('Cart', 'Crawler'));
  void questions.want('Cart');
  asked[0].answer('a cart');
  await settled(() => came.length === 1);
  // It was asked for before the map changed.
  void questions.want('Crawler');
  const onAnotherMap = sceneOf('Cart', 'Crawler');
  questions.keep(onAnotherMap);
  asked[1].answer('a crawler');
  await settled(() => came.length === 2);
  assert.deepEqual(onAnotherMap.classes, { Cart: { description: 'a cart' }, Crawler: { description: 'a crawler' } });
  const late = questions.want('Crawler');
  const ofAnother = sceneOf('Cart');
  questions.restart(ofAnother);
  await late;
  assert.deepEqual(ofAnother.classes, {});
  const wanted = questions.want('Cart');
  asked[2].answer('another cart');
  assert.deepEqual(
    [await wanted, ofAnother.classes.Cart],
    [{ description: 'another cart' }, { description: 'another cart' }],
  );
});
