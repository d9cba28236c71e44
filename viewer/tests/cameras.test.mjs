// Pictures of cameras: as the server sends them, as the page asks for them, and only of the present.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { join } from 'node:path';
import { runnerImport } from 'vite';
import { frameBytes, messageBytes, settled, standInForBrowser } from './messages.mjs';
import { root } from './server.mjs';

const module = async (name) => (await runnerImport(join(root, `viewer/src/${name}.ts`))).module;
const { readMessage } = await module('protocol/frame');
const { Live } = await module('protocol/live');
const { network } = await module('protocol/network');
const { Playback } = await module('playback');

const PNG = [0x89, 0x50, 0x4e, 0x47];
const listenerOf = (names, heard) => Object.fromEntries(names.map((name) => [name, heard]));

const pictureBytes = ({ png, ...picture }) => messageBytes({ picture: { ...picture, png: Uint8Array.from(png) } });

test('a picture names its robot, its sensor and its time, and has a file', () => {
  for (const sent of [
    { robot: 3_000_000_000, sensor: 255, time: 12.345, png: PNG, field_of_view: 1.5 },
    { robot: 0, sensor: 0, time: 0, png: [], field_of_view: 0 },
  ]) {
    const { picture } = readMessage(pictureBytes(sent));
    assert.deepEqual({ ...picture, png: [...picture.png] }, sent);
  }
  const cut = pictureBytes({ robot: 1, sensor: 1, time: 12.5, png: [] }).slice(0, 9);
  assert.throws(() => readMessage(cut), RangeError);
});

test('the page says whose pictures it wants, when that changes and to each server', async (context) => {
  const sockets = [];
  standInForBrowser();
  globalThis.WebSocket = class {
    static OPEN = 1;
    readyState = 1;
    sent = [];
    constructor() {
      sockets.push(this);
    }
    send(text) {
      this.sent.push(JSON.parse(text));
    }
  };
  context.mock.timers.enable({ apis: ['setInterval', 'setTimeout'] });
  context.mock.method(globalThis, 'fetch', async () => Response.json({}));
  const pictures = [];
  const names = ['scene', 'objects', 'frame', 'scan', 'status', 'line', 'said', 'fit', 'lost'];
  const live = new Live(network, { ...listenerOf(names, () => {}), picture: (picture) => pictures.push(picture) });
  await settled(() => sockets.length === 1);
  const [first] = sockets;
  const wishes = () => first.sent.splice(0);
  first.onopen();
  assert.deepEqual(wishes(), [{ wire: false, robots: [], cameras: [] }]);
  live.listenToCameras([2, 5]);
  live.listenToCameras([2, 5]);
  assert.deepEqual(wishes(), [{ wire: false, robots: [], cameras: [2, 5] }]);
  live.listenToRobots([2]);
  assert.deepEqual(wishes(), [{ wire: false, robots: [2], cameras: [2, 5] }]);
  live.listenToCameras([5]);
  assert.deepEqual(wishes(), [{ wire: false, robots: [2], cameras: [5] }]);
  first.onmessage({ data: pictureBytes({ robot: 5, sensor: 1, time: 2, png: PNG }) });
  assert.deepEqual(
    pictures.map(({ robot }) => robot),
    [5],
  );
  // A second for the attempt to connect again.
  first.onclose({ reason: '' });
  context.mock.timers.tick(1000);
  await settled(() => sockets.length === 2);
  const [, second] = sockets;
  second.onopen();
  assert.deepEqual(second.sent, [{ wire: false, robots: [2], cameras: [5] }]);
  live.listenToCameras([]);
  assert.deepEqual(second.sent[1], { wire: false, robots: [2], cameras: [] });
});

test('pictures are shown of the present only', () => {
  const seen = [];
  const names = ['scene', 'objects', 'frame', 'present', 'refilled', 'scan', 'status', 'line', 'jumped', 'changed'];
  const playback = new Playback(network.sceneOfLog, {
    ...listenerOf([...names, 'said'], () => {}),
    picture: ({ time }) => seen.push(time),
    shownTime: () => 0,
  });
  for (const time of [1, 2]) playback.takeFrame(readMessage(frameBytes(time)).frame, frameBytes(time));
  const show = (time) => playback.takePicture({ robot: 0, sensor: 0, time, png: new Uint8Array(PNG) });
  show(2);
  playback.goTo(1);
  show(2.1);
  playback.goLive();
  show(2.2);
  assert.deepEqual(seen, [2, 2.2]);
});
