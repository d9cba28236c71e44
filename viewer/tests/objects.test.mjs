// Movable objects that come and leave: in frames, in the last minute, in logs and in the picture.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { join } from 'node:path';
import { runnerImport } from 'vite';
import { message, writeLog } from './mcap.mjs';
import { frameBytes, settled, standInForBrowser } from './messages.mjs';
import { root } from './server.mjs';

const module = async (name) => (await runnerImport(join(root, `viewer/src/${name}.ts`))).module;
const { readMessage } = await module('protocol/frame');
const { ObjectQuestions } = await module('protocol/objects');
const { Live } = await module('protocol/live');
const { network } = await module('protocol/network');
const { Playback } = await module('playback');
const { LogFile, Player } = await module('log/index');
const { MapView } = await module('view/map');
const { Surfaces } = await module('view/surfaces');
const { moved } = await module('view/moved');

const UPRIGHT = [0, 0, 0, 1];
const pose = (x) => [x, 0, 0, ...UPRIGHT];
const solid = (name, x, shape = { Box: { size: [1, 1, 1] } }) => {
  return { name, shape, pose: pose(x), material: 'wood', colour: [1, 0, 0], friction: 0.5 };
};
const sceneOf = (...objects) => ({
  map: { name: 'test', description: '', solids: [], markings: [], objects, starts: [], path_nodes: [] },
  maps: [],
  names: [],
  classes: {},
});
const statusOf = (resets) => ({ resets, robots: [], recording: null });
const numbersOf = (objects) => objects.map(({ number }) => number);

test('a frame names its objects by their numbers', () => {
  const objects = [
    { number: 1, pose: [0.5, -2, 0.25, ...UPRIGHT] },
    { number: 3_000_000_000, pose: [8, 0, 0, 1, 0, 0, 0] },
  ];
  assert.deepEqual(readMessage(frameBytes(2.5, objects)), { frame: { time: 2.5, robots: [], objects, pulls: [] } });
  assert.deepEqual(readMessage(frameBytes(2.5, [])).frame.objects, []);
});

test('another object at the same place is seen', () => {
  const frame = (...numbers) => ({
    time: 0,
    robots: [],
    objects: numbers.map((number) => ({ number, pose: pose(1) })),
    pulls: [],
  });
  assert.equal(moved(frame(0, 5), frame(0, 5), false), false);
  assert.equal(moved(frame(0, 5), frame(0, 6), false), true);
  assert.equal(moved(frame(0, 5), frame(0), false), true);
  assert.equal(moved(frame(), frame(5), false), true);
});

test('a pull is seen that begins, moves or gets stronger, but not one that holds', () => {
  const frame = (...forces) => ({
    time: 0,
    robots: [],
    objects: [],
    pulls: forces.map((force) => ({ from: [0, 0, 0], to: [0, 0, -0.1], force })),
  });
  for (const [before, after, isSeen] of [
    [[], [9.81], true],
    [[9.81], [], true],
    [[9.81], [9.83], false],
    [[9.81], [9.9], true],
    [[9.81], [9.81, 1], true],
  ]) {
    assert.equal(moved(frame(...before), frame(...after), {}), isSeen, `${before} ${after}`);
  }
  const moving = frame(9.81);
  moving.pulls[0].to = [0, 0, -0.2];
  assert.equal(moved(frame(9.81), moving, {}), true);
});

/** A screen that keeps what it was told last. */
function screen() {
  const ignore = () => {};
  const seen = { scene: null, objects: new Map(), frame: null };
  const keep = Object.fromEntries(Object.keys(seen).map((name) => [name, (value) => (seen[name] = value)]));
  const others = ['robots', 'present', 'refilled', 'scan', 'status', 'line', 'jumped', 'changed', 'said'];
  const listener = { ...keep, ...Object.fromEntries(others.map((name) => [name, ignore])) };
  return { seen, listener: { ...listener, shownTime: () => seen.frame?.time ?? 0 } };
}

test('an object that was removed is still known in the past', () => {
  const { seen, listener } = screen();
  const playback = new Playback(network.sceneOfLog, listener);
  const show = (time, ...numbers) => {
    const bytes = frameBytes(
      time,
      numbers.map((number) => ({ number, pose: pose(number) })),
    );
    playback.takeFrame(readMessage(bytes).frame, bytes);
  };
  playback.takeScene(sceneOf(solid('ofMap', 0)));
  playback.takeStatus(statusOf(0));
  show(1, 0, 7);
  const came = { number: 7, ...solid('came', 7) };
  playback.takeObjects([came]);
  show(2, 0, 7);
  // It is not drawn anew for what is the same.
  playback.takeObjects([{ ...came }, { number: 8, ...solid('next', 8) }]);
  assert.equal(seen.objects.get(7), came);
  playback.takeObjects([]);
  show(3);
  assert.deepEqual(seen.frame.objects, []);
  playback.goTo(2.5);
  assert.deepEqual(numbersOf(seen.frame.objects), [0, 7]);
  assert.equal(seen.objects.get(7).name, 'came');
  // A fresh world gives the same numbers to others.
  playback.takeStatus(statusOf(1));
  assert.equal(seen.objects.size, 0);
  playback.takeObjects([{ number: 7, ...solid('other', 7) }]);
  assert.equal(seen.objects.get(7).name, 'other');
  playback.takeScene(sceneOf());
  assert.equal(seen.objects.size, 0);
});

test('the server is asked for objects once at a time, and of the world that is shown', async (context) => {
  standInForBrowser();
  const asked = [];
  context.mock.method(globalThis, 'fetch', (name) => {
    return new Promise((resolve, reject) =>
      asked.push({ name, reject, answer: (list) => resolve(Response.json(list)) }),
    );
  });
  const seen = [];
  const questions = new ObjectQuestions(
    (objects) => seen.push(...numbersOf(objects)),
    () => seen.push('failed'),
    network.objects,
  );
  for (let change = 0; change < 3; change++) questions.ask();
  assert.deepEqual([asked.length, asked[0].name], [1, 'objects.json']);
  asked[0].answer([{ number: 1 }]);
  await settled(() => asked.length === 2);
  assert.deepEqual([seen, asked.length], [[1], 2]);
  questions.restart();
  questions.ask();
  asked[1].answer([{ number: 2 }]);
  asked[2].answer([{ number: 3 }]);
  await settled(() => seen.length === 2);
  assert.deepEqual([seen, asked.length], [[1, 3], 3]);
  questions.ask();
  asked[3].reject(new Error('gone'));
  await settled(() => seen.length === 3);
  assert.deepEqual(seen, [1, 3, 'failed']);
});

test('objects are fetched with the first status, when they change and after a scene', async (context) => {
  const sockets = [];
  standInForBrowser();
  globalThis.WebSocket = class {
    constructor() {
      sockets.push(this);
    }
  };
  context.mock.timers.enable({ apis: ['setInterval'] });
  const seen = [];
  context.mock.method(globalThis, 'fetch', async (name) => Response.json({ name, names: [] }));
  const names = ['frame', 'scan', 'line', 'said', 'fit', 'lost'];
  new Live(network, {
    ...Object.fromEntries(names.map((name) => [name, () => {}])),
    scene: ({ name }) => seen.push(name),
    objects: ({ name }) => seen.push(name),
    status: () => seen.push('status'),
  });
  await settled(() => sockets.length === 1);
  assert.deepEqual(seen, ['scene.json']);
  for (const [scene, resets, objects, expected] of [
    [0, 0, 0, 'status objects.json'],
    [0, 0, 0, 'status'],
    [0, 0, 1, 'status objects.json'],
    [0, 1, 1, 'status objects.json'],
    [1, 2, 1, 'scene.json objects.json'],
    [1, 2, 1, 'status'],
  ]) {
    seen.length = 0;
    sockets[0].onmessage({ data: JSON.stringify({ status: { scene, resets, objects, robots: [] } }) });
    await settled(() => seen.join(' ') === expected);
    assert.equal(seen.join(' '), expected);
  }
});

test('the picture has the objects of the frame that are known', () => {
  const known = new Map([[0, solid('ofMap', 0)]]);
  const view = new MapView(sceneOf(known.get(0)), new Surfaces(1), (number) => known.get(number) ?? null);
  const bodies = () => view.group.children.filter(({ userData }) => userData.surface);
  const places = () => bodies().map(({ position }) => position.x);
  const frame = (...numbers) => numbers.map((number) => ({ number, pose: pose(10 * number) }));
  assert.deepEqual(places(), [0]);
  view.place(frame(0, 4));
  assert.deepEqual(places(), [0]);
  const points = [
    [0, 0, 0],
    [2, 0, 0],
    [0, 4, 0],
    [0, 0, -6],
  ];
  known.set(4, solid('hull', 0, { Hull: { points } }));
  view.place(frame(0, 4));
  assert.deepEqual(places(), [0, 40]);
  const [, hull] = bodies();
  hull.geometry.computeBoundingBox();
  const { min, max } = hull.geometry.boundingBox;
  assert.deepEqual([min.toArray(), max.toArray()].flat().map(Math.round), [0, 0, -6, 2, 4, 0].map(Math.round));
  view.place(frame(4));
  assert.deepEqual(places(), [40]);
  assert.equal(bodies()[0], hull);
  // Another world gives the number to another object.
  known.set(4, solid('ball', 0, { Ball: { radius: 1 } }));
  view.place(frame(4));
  assert.equal(bodies().length, 1);
  assert.notEqual(bodies()[0], hull);
  view.place([]);
  assert.deepEqual(places(), []);
  view.place(frame(0));
  assert.deepEqual(places(), [0]);
  view.dispose();
});

const definition = (name, position, rotation = [0, 0, 0], shape = { Ball: { radius: 0.5 } }) => {
  const material = { name: 'wood', friction: 0.5, colour: [1, 0.5, 0] };
  return JSON.stringify({ solid: { name, shape, position, rotation, material }, mass: 2 });
};
const run = { format: '2', scene: 'stored' };
const { state, spawned, removed, line } = message;

/**
 * Objects 0 and 1 are of the map. 2 comes at 2 s to place 2, moves at 3 s and leaves at 5 s; 3 comes at 4 s; 4 comes at 6 s to the
 * place that 2 had. 1 leaves at 7 s.
 */
const CHUNKS = [
  [state(0, 0, 0, pose(0.5)), state(0, 1, 1, pose(1.5)), line(0.5)],
  [line(1), spawned(2, 2, definition('Two', [2, 0, 0])), state(2, 2, 2, pose(2)), state(3, 2, 2, pose(2.5))],
  [line(3.5), spawned(4, 3, definition('Three', [3, 0, 0], [0.1, 0.2, 0.3])), removed(5, 2)],
  [line(5.5), spawned(6, 4, definition('Four', [4, 0, 0])), state(6, 2, 4, pose(4)), state(6.5, 2, 4, pose(4.5))],
  [line(6.8), spawned(6.9, 5, 'no JSON'), removed(7, 1), line(8)],
];
const open = (bytes) => LogFile.open(new Blob([bytes]), async () => sceneOf(solid('Zero', 0), solid('One', 1)));
const xOf = ({ objects }) => objects.map(({ number, pose }) => [number, pose[0]]);

/** What is there at some times. */
// prettier-ignore
const THERE = new Map([
  [0, [[0, 0.5], [1, 1.5]]],
  [1.9, [[0, 0.5], [1, 1.5]]],
  [2, [[0, 0.5], [1, 1.5], [2, 2]]],
  [3.2, [[0, 0.5], [1, 1.5], [2, 2.5]]],
  [4.5, [[0, 0.5], [1, 1.5], [2, 2.5], [3, 3]]],
  [5, [[0, 0.5], [1, 1.5], [3, 3]]],
  [6.2, [[0, 0.5], [1, 1.5], [3, 3], [4, 4]]],
  [6.9, [[0, 0.5], [1, 1.5], [3, 3], [4, 4.5]]],
  [8, [[0, 0.5], [3, 3], [4, 4.5]]],
]);

test('a log has the objects of each moment', async () => {
  for (const order of [[...THERE], [...THERE].reverse()]) {
    const log = await open(writeLog(run, CHUNKS));
    assert.equal(log.damage, null);
    for (const [time, there] of order) assert.deepEqual(xOf(await log.frameAt(time)), there, `${time} s`);
    // All at once, too.
    const moments = await Promise.all(order.map(([time]) => log.momentAt(time)));
    assert.deepEqual(
      moments.map(({ frame }) => xOf(frame)),
      order.map(([, there]) => there),
    );
  }
});

test('a log without its index has them, too', async () => {
  const bytes = writeLog(run, CHUNKS);
  const log = await open(bytes.subarray(0, bytes.length - 20));
  assert.match(log.damage, /index/);
  for (const [time, there] of THERE) assert.deepEqual(xOf(await log.frameAt(time)), there, `${time} s`);
});

test('a log says what its objects are', async () => {
  const log = await open(writeLog(run, CHUNKS));
  const { spawned } = await log.momentAt(4.5);
  assert.deepEqual([...spawned.keys()], [2, 3]);
  const { pose, ...three } = spawned.get(3);
  const expected = { name: 'Three', shape: { Ball: { radius: 0.5 } }, material: 'wood', colour: [1, 0.5, 0] };
  assert.deepEqual(three, { ...expected, friction: 0.5 });
  // As nalgebra's from_euler_angles(0.1, 0.2, 0.3).
  const known = [3, 0, 0, 0.0342708, 0.1060205, 0.1435722, 0.9833474];
  assert.ok(
    pose.every((value, at) => Math.abs(value - known[at]) < 1e-6),
    `${pose}`,
  );
  assert.equal((await log.momentAt(6.2)).spawned.get(3), spawned.get(3));
});

test('damage hides only the objects of its time', async () => {
  const bytes = writeLog(run, CHUNKS);
  // The opcode of a record in the second chunk.
  const at = bytes.indexOf('/objects/spawned');
  bytes.fill(255, at - 20, at);
  const log = await open(bytes);
  await assert.rejects(log.frameAt(2), /damaged/);
  assert.deepEqual((await log.momentAt(8)).spawned.get(4).name, 'Four');
});

test('of a long log only what tells of objects is read, and once', async () => {
  const quiet = (from) => Array.from({ length: 500 }, (_, at) => [line(from + at), line(from + at + 0.9)]);
  const chunks = [...CHUNKS, ...quiet(10), [spawned(600, 9, definition('Nine', [9, 0, 0])), line(601)], ...quiet(700)];
  const bytes = new Blob([writeLog(run, chunks)]);
  let reads = 0;
  const counting = {
    size: bytes.size,
    slice: (...range) => {
      reads += 1;
      return bytes.slice(...range);
    },
  };
  const log = await LogFile.open(counting, async () => sceneOf(solid('Zero', 0), solid('One', 1)));
  const opened = reads;
  assert.deepEqual(xOf(await log.frameAt(8)), THERE.get(8));
  assert.ok(reads - opened <= CHUNKS.length, `${reads - opened} reads`);
  assert.deepEqual(numbersOf((await log.frameAt(1100)).objects), [0, 3, 4, 9]);
  assert.ok(reads - opened <= CHUNKS.length + 3, `${reads - opened} reads`);
});

test('a player tells of objects before their frame', async () => {
  const log = await open(writeLog(run, CHUNKS));
  const seen = [];
  const ignore = () => {};
  const player = new Player(log, {
    frame: ({ time, objects }) => seen.push([time, numbersOf(objects)]),
    objects: (objects) => seen.push([...objects.values()].map(({ name }) => name)),
    status: ignore,
    scan: ignore,
    line: ignore,
    jumped: ignore,
    ended: ignore,
    failed: (reason) => seen.push(reason),
  });
  for (const time of [1, 2, 3, 5]) await player.seek(time);
  assert.deepEqual(seen, [[1, [0, 1]], ['Two'], [2, [0, 1, 2]], [3, [0, 1, 2]], ['Three'], [5, [0, 1, 3]]]);
});
