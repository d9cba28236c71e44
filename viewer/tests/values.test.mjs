// Numbers of a robot that the page shows and plots.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { runnerImport } from 'vite';
import { root } from './server.mjs';

const { valuesOf } = (await runnerImport(join(root, 'viewer/src/values.ts'))).module;

const wheel = (y, link = null) => ({ name: `${y}`, link, position: [0.1, y, 0] });
const skid = { steering: 'SkidSteered', wheel_radius: 0.1, track: 0.4, wheels: [wheel(0.2), wheel(-0.2)], joints: [] };

/** The effective over the true track of a robot whose left wheel turns at 3 rad/s and whose right one at -3 rad/s. */
function chi(robotClass, clockwise) {
  const group = valuesOf(robotClass, new Map()).find(({ name }) => name === 'Turn');
  return group?.values[0].read({ wheels: [{ speed: -3 }, { speed: 3 }], angular: [0, 0, clockwise] }, new Map());
}

test('the effective track of a robot that turns is that of its wheels and its yaw rate', () => {
  assert.ok(Math.abs(chi(skid, 1.5) - 1) < 1e-9);
  assert.ok(Math.abs(chi(skid, 1) - 1.5) < 1e-9);
  assert.equal(chi(skid, 0.001), null);
  // It turns against its wheels.
  assert.ok(chi(skid, -1) < 0);
});

test('robots without two sides of wheels on their body have no effective track', () => {
  for (const other of [
    { ...skid, steering: 'OmniDrive' },
    { ...skid, wheels: [wheel(0.2), wheel(0.2)] },
    { ...skid, wheels: [wheel(0.2), wheel(-0.2, 1)] },
    { ...skid, track: 0 },
  ]) {
    assert.equal(chi(other, 1), undefined);
  }
});

test('the grip of a wheel is the mean of its contacts by their forces', () => {
  const group = valuesOf(skid, new Map()).find(({ name }) => name === 'Grip');
  const on = (wheel, force, slip, share) => ({ wheel, force: [0, 0, -force], slip: [slip, 0, 0], share });
  const contacts = [on(1, 30, 0.1, 1), on(1, 10, 0.02, 0.6), on(null, 50, 9, 1)];
  const read = group.values.map((value) => value.read({ contacts }, new Map()));
  assert.deepEqual(
    group.values.map(({ name }) => name),
    ['0.2 slip', '0.2 friction', '-0.2 slip', '-0.2 friction'],
  );
  assert.deepEqual(read.slice(0, 2), [null, null], 'a wheel in the air');
  assert.ok(Math.abs(read[2] - 80) < 1e-9 && Math.abs(read[3] - 90) < 1e-9, `${read}`);
});
