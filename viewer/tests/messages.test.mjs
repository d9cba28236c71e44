// The page reads every binary message as live.proto defines it, by the generated reader.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { runnerImport } from 'vite';
import { generated } from '../generate.mjs';
import { messageBytes } from './messages.mjs';
import { root } from './server.mjs';

const { module } = await runnerImport(join(root, 'viewer/src/protocol/frame.ts'));
const read = (message) => module.readMessage(messageBytes(message));

test('the reader is that of live.proto', () => {
  for (const [path, text] of Object.entries(generated())) {
    assert.equal(readFileSync(join(root, 'viewer', path), 'utf8'), text, `npm run generate renews ${path}`);
  }
});

test('a robot has every number of its message', () => {
  const robot = {
    robot: 3_000_000_000,
    pose: [1, 2, 3, 0, 0, 0, 1],
    linear: [0.5, 0, -0.25],
    angular: [0, 0, 2],
    wheels: [
      { angle: 100.5, speed: -3, target: -4, rollers: [0, 16384, -32768] },
      { angle: 0, speed: 0, target: 0, rollers: [] },
    ],
    links: [1, 0, 0, 0, 0, 0, 1, 2, 0, 0, 1, 0, 0, 0],
    joint_positions: [0.5, -0.5],
    joint_speeds: [0, 1],
    contact_points: [1, 2, 3, 4, 5, 6],
    contact_forces: [0, 0, -400, 4, 8, 12],
    contact_wheels: [0, 2],
    contact_slips: [0, 0, 0, 10000, -5000, 0],
    contact_shares: [0, 100],
  };
  const { frame } = read({
    frame: { time: 2.5, robots: [robot], objects: [], pulls: [{ line: [1, 2, 3, 4, 5, 6], force: 7.5 }] },
  });
  assert.deepEqual(frame, {
    time: 2.5,
    objects: [],
    pulls: [{ from: [1, 2, 3], to: [4, 5, 6], force: 7.5 }],
    robots: [
      {
        id: 3_000_000_000,
        pose: robot.pose,
        linear: robot.linear,
        angular: robot.angular,
        wheels: [
          { angle: 100.5, speed: -3, target: -4, rollers: [0, Math.PI / 2, -Math.PI] },
          { angle: 0, speed: 0, target: 0, rollers: [] },
        ],
        links: [
          [1, 0, 0, 0, 0, 0, 1],
          [2, 0, 0, 1, 0, 0, 0],
        ],
        joints: [
          { position: 0.5, speed: 0 },
          { position: -0.5, speed: 1 },
        ],
        contacts: [
          { point: [1, 2, 3], force: [0, 0, -100], wheel: null, slip: [0, 0, 0], share: 0 },
          { point: [4, 5, 6], force: [1, 2, 3], wheel: 1, slip: [1, -0.5, 0], share: 1 },
        ],
      },
    ],
  });
});

test('ranges of a scan are parts of the range', () => {
  const { scan } = read({ scan: { robot: 2, sensor: 5, ranges: [0, 65535] } });
  assert.deepEqual(scan, { robot: 2, sensor: 5, ranges: [0, 1] });
});

test('a message of another kind is no message', () => {
  assert.equal(module.readMessage(Uint8Array.from([0x3a, 1, 0]).buffer), null);
});
