// Joints that bring a hand to a place, and lines of programs that wait.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { runnerImport } from 'vite';
import { root } from './server.mjs';

const module = async (name) => (await runnerImport(join(root, `viewer/src/${name}.ts`))).module;
const { reach, moversOf, nudged } = await module('arm');
const { markWaiting, plainError } = await module('code/lines');
const { readingIn } = await module('protocol/line');

const pose = (x, z) => [x, 0, z, 0, 0, 0, 1];
/** An arm of three links of 1 m upward, which bends ahead, on a base that turns; a finger at its end. */
const arm = {
  links: [
    { name: 'turn', parent: null, pose: pose(0, 0) },
    { name: 'lower', parent: 0, pose: pose(0, 0) },
    { name: 'upper', parent: 1, pose: pose(0, -1) },
    { name: 'hand', parent: 2, pose: pose(0, -2) },
    { name: 'finger', parent: 3, pose: pose(0, -2.9) },
  ],
  joints: [
    { name: 'turn', axis: [0, 0, 1], min: -3, max: 3, unit: 'rad' },
    { name: 'lower', axis: [0, -1, 0], min: -2, max: 2, unit: 'rad' },
    { name: 'upper', axis: [0, -1, 0], min: -2, max: 2, unit: 'rad' },
    { name: 'hand', axis: [0, -1, 0], min: -2, max: 2, unit: 'rad' },
    { name: 'finger', axis: [0, 1, 0], min: 0, max: 0.1, unit: 'm' },
  ],
  grippers: [{ name: 'grip', joints: ['finger'], link: 3, middle: [0, 0, -1] }],
};
const TIP = [0, 0, -1];

test('joints bring the tip to what is in reach, within their limits, and as near as can be to the rest', () => {
  const from = [0.1, 0.2, 0.3, 0.2, 0];
  for (const [to, left] of [
    [[1.5, 0, -1], 0],
    [[1, 1, -1.5], 0],
    [[0, -2, 0], 0],
    [[-1, 0.5, -0.5], 0],
    [[0, 0, -2.99], 0],
    // Farther than the arm is long.
    [[5, 0, 0], 2],
    [[0, 0, -4], 1],
  ]) {
    const { positions, way } = reach(arm, from, { link: 3, grip: TIP, to, facing: null });
    assert.ok(Math.abs(way - left) < 0.02, `${to}: ${way} m left, not ${left}`);
    arm.joints.forEach(({ min, max }, index) => assert.ok(min <= positions[index] && positions[index] <= max, `${to}`));
    assert.equal(positions[4], 0, 'fingers only grip');
    assert.deepEqual(reach(arm, from, { link: 3, grip: TIP, to, facing: null }).positions, positions);
  }
});

test('the hand is moved by a centimetre along an axis of the robot, and not out of its reach', () => {
  let positions = [0, 0.4, 0.5, 0.3, 0];
  const ahead = nudged(arm, positions, [0.01, 0, 0]);
  assert.notDeepEqual(ahead, positions);
  // There and back again on all axes.
  for (const way of [
    [0.01, 0, 0],
    [0, 0.01, 0],
    [0, 0, -0.01],
    [-0.01, 0, 0],
    [0, -0.01, 0],
    [0, 0, 0.01],
  ]) {
    positions = nudged(arm, positions, way);
  }
  [0, 0.4, 0.5, 0.3, 0].forEach((position, index) => assert.ok(Math.abs(positions[index] - position) < 0.01));
  // Upright it is as long as it can be.
  assert.equal(nudged(arm, [0, 0, 0, 0, 0], [0, 0, -0.01]), null);
});

test('a link is moved by the joints between it and the body, but not by fingers', () => {
  const names = (link) => moversOf(arm, link).map(({ joint }) => arm.joints[joint].name);
  assert.deepEqual(names(1), ['turn', 'lower']);
  assert.deepEqual(names(4), ['turn', 'lower', 'upper', 'hand']);
});

test('lines that wait are marked where a statement begins', () => {
  for (const [program, marked] of [
    ['await a()', [1]],
    ['x = 1\n  y = await a(x)', [2]],
    ['print(await a())\n# await b()', [1]],
    ['if await a():\n  await b()', [2]],
    ['await a(\n  await b(),\n)', [1]],
    ['text = """\nawait a()\n"""\nawait b()', [4]],
    ["say('await')\nsay(\"it's\")\nawait a()", [3]],
    ['async def f():\n  return await a()', [2]],
    ['"\\"await\nawait a()', [2]],
  ]) {
    const lines = markWaiting(program).split('\n');
    const found = lines.flatMap((line, index) => (line.includes(`_page.at(${index + 1}); `) ? [index + 1] : []));
    assert.deepEqual(found, marked, program);
    assert.deepEqual(lines.map((line) => line.replace(/_page\.at\(\d+\); /, '')).join('\n'), program);
  }
});

test('an error names the last line of the program that led to it', () => {
  const traceback =
    'Traceback (most recent call last):\n  File "<stdin>", line 3, in <module>\n  File "<stdin>", line 2, in f\nNameError: no\n';
  assert.equal(plainError(traceback), 'line 2: NameError: no');
  assert.equal(plainError('MemoryError: '), 'MemoryError:');
});

test('a reading is found by the name or the type of its sensor', () => {
  const laser = 'SEN {Time 1.5} {Type RangeScanner} {Name lms} {Resolution 0.01} {Range 4.00,4.50}';
  const sonars = 'SEN {Time 2} {Type Sonar} {Name F1} {Range 1.5} {Name F2} {Range 2.5}';
  for (const [line, sensor, expected] of [
    [laser, 'lms', { Time: 1.5, Type: 'RangeScanner', Name: 'lms', Resolution: 0.01, Range: [4, 4.5] }],
    [laser, 'RangeScanner', { Time: 1.5, Type: 'RangeScanner', Name: 'lms', Resolution: 0.01, Range: [4, 4.5] }],
    [sonars, 'F2', { Time: 2, Type: 'Sonar', Name: 'F2', Range: 2.5 }],
    [sonars, 'Sonar', { Time: 2, Type: 'Sonar', Name: 'F1', Range: 1.5 }],
    [sonars, 'F3', null],
    ['STA {Time 1} {Name lms}', 'lms', null],
    ['SEN {Type Touch} {Name T} {Touch True}', 'T', { Type: 'Touch', Name: 'T', Touch: 'True' }],
  ])
    assert.deepEqual(readingIn(line, sensor), expected, line);
});
