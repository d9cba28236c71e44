// The run so far, kept in the page: which frames stay, and when the world was too slow.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { runnerImport } from 'vite';
import { frameBytes } from './messages.mjs';
import { root } from './server.mjs';

const { History } = (await runnerImport(join(root, 'viewer/src/history.ts'))).module;
const { Marks } = (await runnerImport(join(root, 'viewer/src/marks.ts'))).module;

test('the whole run can be looked at, the last minute frame by frame', () => {
  const history = new History();
  const seconds = 1200;
  for (let frame = 0; frame <= 30 * seconds; frame++) history.add(frame / 30, frameBytes(frame / 30));
  assert.deepEqual(history.range, [0, seconds]);
  for (let frame = 30 * (seconds - 60) + 1; frame <= 30 * seconds; frame++) {
    assert.equal(history.at(frame / 30).time, frame / 30);
  }
  for (let time = 0; time < seconds; time += 7.3) assert.ok(time - history.at(time).time < 3, `${time} s`);
  const kept = history.sample(1e9).length;
  assert.ok(kept > 3000 && kept <= 5400, `${kept} frames`);
});

test('one goes from frame to frame, however far they lie apart', () => {
  const history = new History();
  for (const time of [1, 1.002, 1.03, 9]) history.add(time, frameBytes(time));
  for (const [time, before, after] of [
    [0.5, 1, 1],
    [1, 1, 1.002],
    [1.002, 1, 1.03],
    [1.02, 1.002, 1.03],
    [9, 1.03, 9],
    [10, 9, 9],
  ]) {
    assert.deepEqual([history.before(time), history.after(time)], [before, after], `${time} s`);
  }
});

test('frames of the time before the page was opened come before its own', () => {
  const history = new History();
  for (const time of [10, 10.1, 10.2]) history.add(time, frameBytes(time));
  history.prepend([0, 4, 8, 10, 12].map((time) => frameBytes(time)));
  assert.deepEqual(
    history.sample(10).map(({ time }) => time),
    [0, 4, 8, 10, 10.1, 10.2],
  );
  const marks = new Marks();
  marks.takePast(
    [
      { robot: 1, class: 'P3AT', name: 'Ann', came: 3, left: 7 },
      { robot: 2, class: 'P3AT', name: '', came: 5, left: 0 },
      { robot: 3, class: 'P3AT', name: 'Bob', came: 0, left: 11 },
    ],
    10,
  );
  assert.deepEqual(
    marks.list.map(({ time, what }) => [time, what]),
    [
      [3, 'Ann came'],
      [5, 'P3AT #2 came'],
      [7, 'Ann left'],
    ],
  );
});

test('a world with huge frames keeps what fits', () => {
  const history = new History();
  for (let frame = 0; frame < 400; frame++) {
    history.add(
      frame,
      frameBytes(
        frame,
        Array.from({ length: 8000 }, (_, number) => ({ number, pose: [0, 0, 0, 0, 0, 0, 1] })),
      ),
    );
  }
  assert.deepEqual(history.range, [0, 399]);
  assert.ok(history.sample(1e9).length < 260);
});

test('times in which the world was slower than asked for are noted', () => {
  const marks = new Marks();
  const pace = (time, real_time_factor, speed = 1, paused = false) =>
    marks.takePace(time, { real_time_factor, speed, paused });
  pace(1, 1);
  pace(2, 0.95);
  pace(3, 0.6);
  pace(3.5, 0.4);
  pace(6, 1);
  pace(9, 0.8);
  pace(12, 1, 2);
  pace(13, 0.1, 0);
  pace(14, 0, 1, true);
  assert.deepEqual(marks.late, [
    { from: 2.7, to: 3.5, factor: 0.4 },
    { from: 8.6, to: 9, factor: 0.8 },
    { from: 11.5, to: 12, factor: 1 },
  ]);
});
