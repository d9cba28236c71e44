// Colours of robots, teams and curves.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { runnerImport } from 'vite';
import { root } from './server.mjs';

const colours = (await runnerImport(join(root, 'viewer/src/view/colours.ts'))).module;
const { bodyColour, COLOURS, colourOf, curveColours, teamColour } = colours;

test('a colour goes by the name, and numbered names differ', () => {
  assert.equal(colourOf({ id: 0, name: 'Ann' }), colourOf({ id: 7, name: 'Ann' }));
  for (const stem of ['Robot', 'R', 'Student', '']) {
    const named = COLOURS.map((_, index) => colourOf({ id: 0, name: `${stem}${index + 1}` }));
    assert.equal(new Set(named).size, COLOURS.length, stem);
  }
  assert.equal(colourOf({ id: 3, name: 'Robot1' }), COLOURS[0]);
  const nameless = COLOURS.map((_, id) => colourOf({ id, name: '' }));
  assert.equal(new Set(nameless).size, COLOURS.length);
  for (const name of ['x'.repeat(256), '😀', '9'.repeat(40)]) assert.ok(COLOURS.includes(colourOf({ id: 0, name })));
});

test('a colour is unlike that of the body', () => {
  const linear = (hex) =>
    [1, 3, 5].map((at) => Number.parseInt(hex.slice(at, at + 2), 16) / 255).map((part) => part ** 2.2);
  for (const body of COLOURS.slice(0, 9)) {
    for (let number = 1; number <= 10; number++) {
      assert.notEqual(colourOf({ id: 0, name: `Robot${number}` }, linear(body)), body);
    }
  }
  assert.equal(colourOf({ id: 0, name: 'Robot1' }, linear('#d64550')), COLOURS[0]);
  // The body of a robot is what is drawn most; greys do not count.
  const box = (edge, colour) => ({ shape: { Box: { size: [edge, edge, edge] } }, colour });
  const drawn = [box(1, [0.1, 0.1, 0.1]), box(0.5, [0.8, 0.2, 0]), box(0.1, [0, 0, 1])];
  assert.deepEqual(bodyColour({ drawn, links: [] }), [0.8, 0.2, 0]);
  assert.equal(bodyColour({ drawn: drawn.slice(0, 1), links: [] }), null);
});

test('the first curve of a robot has its colour, and no other curve has it', () => {
  const [blue, orange, green, pink] = COLOURS;
  for (const [curves, expected] of [
    ['', []],
    ['g', [green]],
    ['ggb', [green, orange, blue]],
    ['gbgb', [green, blue, orange, pink]],
  ]) {
    const robots = { b: { thing: 'robot 1', colour: blue }, g: { thing: 'robot 2', colour: green } };
    assert.deepEqual(curveColours([...curves].map((letter) => robots[letter])), expected, curves);
  }
  const many = curveColours(Array.from({ length: 30 }, () => ({ thing: 'robot 1', colour: blue })));
  assert.equal(many.filter((colour) => colour === blue).length, 1);
});

test('a team has the colour of its name, or one of its place', () => {
  assert.notEqual(teamColour('Red', 0), teamColour('blue', 0));
  assert.equal(teamColour('Owls', 2), COLOURS[2]);
});
