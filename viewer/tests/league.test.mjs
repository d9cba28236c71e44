// A league: teams and their starts, and the score board.

import assert from 'node:assert/strict';
import { mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { runnerImport } from 'vite';
import { X, pageTest } from './pagetest.mjs';
import { connectClient, number, root, waitForNumber } from './server.mjs';

const { refusal } = (await runnerImport(join(root, 'viewer/src/protocol/refusal.ts'))).module;

/** A league on the map `rescue` whose first zone is at the start of one team. */
const file = join(mkdtempSync(join(tmpdir(), 'league-')), 'league.toml');
writeFileSync(
  file,
  `name = "Cup <b>of</b> Zones"
map = "rescue"
time_limit = 300

[[team]]
name = "red"
starts = ["RobotStart1"]

[[team]]
name = "blue"
starts = ["RobotStart2"]

[[zone]]
name = "gate"
position = [-6.6, 2.2, -0.5]
size = [1.0, 1.0, 2.0]
points = 15
`,
);

/** A league of two teams with other classes each. */
const classes = join(mkdtempSync(join(tmpdir(), 'league-')), 'league.toml');
writeFileSync(
  classes,
  `name = "Classes"
map = "rescue"

[[team]]
name = "red"
starts = ["RobotStart1"]
classes = ["Kenaf", "P3AT"]

[[team]]
name = "blue"
starts = ["RobotStart2"]
classes = ["P3AT", "ATRV"]
`,
);

const text = (page, selector) => page.locator(selector).first().textContent();
const shows = (page, selector, text) =>
  page.waitForFunction(([selector, text]) => document.querySelector(selector)?.textContent === text, [selector, text]);

pageTest(
  'the board shows points and time, and fills the page for a hall',
  { serve: ['--league', file] },
  async (it) => {
    const { page, server } = it;
    await shows(page, '#board-name', 'Cup <b>of</b> Zones');
    assert.equal(await text(page, '#board-time'), '5:00');
    const client = await connectClient(server.port);
    client.send('INIT {ClassName USARBot.P3AT} {Name Ann} {Team blue}');
    await shows(page, '[data-team=blue] .points', '15');
    assert.equal(await text(page, '[data-team=blue] .place'), '1');
    assert.equal(await text(page, '[data-team=red] .place'), '2');
    assert.equal(await text(page, '[data-team=blue] .scores'), '+15 reached gate');
    await page.waitForFunction(() => document.querySelector('#board-time').textContent.startsWith('4:'));
    await page.keyboard.press('b');
    await page.waitForFunction(() => document.querySelector('#board').getBoundingClientRect().width === innerWidth);
    const standings = await page.evaluate(async () => (await fetch('/league.json')).json());
    assert.deepEqual(
      standings.teams.map(({ team, points }) => [team, points]),
      [
        ['red', 0],
        ['blue', 15],
      ],
    );
    client.end();
  },
);

const starts = (page) => page.locator('select[name=start] option').allTextContents();
const toasts = (page) => page.locator('#toasts p').allTextContents();
const init = (name, team) => `INIT {ClassName USARBot.P3AT} {Name ${name}} {Team ${team}}`;

pageTest('a robot enters at a start of a team', { serve: ['--league', 'rescue'] }, async ({ page }) => {
  await page.click('[data-tab=drive]');
  assert.deepEqual(await starts(page), ['red 1', 'red 2', 'blue 1', 'blue 2']);
  await page.selectOption('select[name=start]', 'blue 1');
  await page.click('#spawn');
  await shows(page, '[data-team=blue] .about', 'Robot1 · 0 of 6 victims');
  assert.equal(await text(page, '[data-team=red] .about'), 'no robot · 0 of 6 victims');
  const colours = ['red', 'blue'].map((team) =>
    page.locator(`[data-team=${team}]`).evaluate((row) => row.style.getPropertyValue('--team')),
  );
  assert.deepEqual(await Promise.all(colours), ['#d64550', '#1f83d6']);
  await page.waitForFunction(() => document.querySelector('select[name=start]').options[2].text === 'blue 1 (taken)');
  assert.equal(await page.inputValue('select[name=start]'), 'red 1');
  await page.waitForSelector('.view-label.start:text-is("red 1")', { state: 'attached' });
  assert.equal(await page.locator('.view-label.start:text-is("PlayerStart_0")').count(), 0);
  await page.keyboard.down('w');
  await waitForNumber(page, X, (x) => x > -6.4);
  await page.keyboard.up('w');
  assert.deepEqual(await toasts(page), []);
});

pageTest('a robot that a league refuses leaves nothing behind', { serve: ['--league', 'rescue'] }, async (it) => {
  const { page, server } = it;
  const clients = [
    await connectClient(server.port, init('Ann', 'red')),
    await connectClient(server.port, init('Bob', 'red')),
  ];
  await page.waitForSelector('[data-robot="1"]', { state: 'attached' });
  await page.click('[data-tab=drive]');
  await page.waitForFunction(() => document.querySelector('select[name=start]').options[1].text === 'red 2 (taken)');
  const refuse = async (name) => {
    await page.selectOption('select[name=start]', 'red 1');
    await page.click('#spawn');
    const why = 'team red has all its robots in the world: choose another team';
    await page.waitForSelector(`#toasts :text-is("${name} was refused: ${why}")`);
  };
  await refuse('Robot1');
  await page.waitForSelector('#drive h2:text-is("Driving")', { state: 'hidden' });
  await page.waitForFunction(() => !document.querySelector('#world').textContent.includes('no robot'));
  // A robot that is driven already goes on being driven.
  await page.selectOption('select[name=start]', 'blue 2');
  await page.click('#spawn');
  await page.waitForSelector('[data-robot="2"][aria-pressed=true]', { state: 'attached' });
  await page.waitForFunction(() => document.querySelector('[name=name]').value === 'Robot2');
  await refuse('Robot2');
  await page.waitForFunction(() => document.querySelector('select[name=own]').length === 1);
  assert.equal(await page.locator('select[name=own] option').textContent(), 'Robot1');
  const x = await number(page, X);
  await page.keyboard.down('w');
  await waitForNumber(page, X, (value) => value > x + 0.1);
  await page.keyboard.up('w');
  // Nothing is told of lines that a person has not written.
  const told = await toasts(page);
  assert.ok(
    told.every((text) => text.includes(' was refused: ')),
    `${told}`,
  );
  for (const client of clients) client.end();
});

pageTest(
  'only classes and starts of teams that have them are offered',
  { serve: ['--league', classes] },
  async (it) => {
    const { page } = it;
    await page.click('[data-tab=drive]');
    assert.deepEqual(await page.locator('select[name=class] option').allTextContents(), ['ATRV', 'Kenaf', 'P3AT']);
    assert.deepEqual(await page.locator('.card strong').allTextContents(), ['Kenaf', 'P3AT']);
    for (const [robotClass, expected] of [
      ['Kenaf', ['red 1']],
      ['P3AT', ['red 1', 'blue 1']],
      ['ATRV', ['blue 1']],
    ]) {
      await page.selectOption('select[name=class]', robotClass);
      assert.deepEqual(await starts(page), expected);
    }
    await page.click('[data-spawn=Kenaf]');
    await shows(page, '[data-team=red] .about', 'Robot1');
  },
);

test('refusals have the words of the page', () => {
  for (const [error, words] of [
    ['INIT refused: the world holds 256 robots already', 'the world holds 256 robots already'],
    ['INIT: expected {Team ..} with one of red, blue; no robot is spawned', 'choose a team: red, blue'],
    [
      'INIT: no team `green`: expected {Team ..} with one of red, blue; no robot is spawned',
      'there is no team green: choose red, blue',
    ],
    [
      'INIT: team red has no P3AT: expected one of Kenaf; no robot is spawned',
      'team red may not have a P3AT: choose Kenaf',
    ],
    [
      "INIT: {Team blue}: expected red, the team of the connection's token; no robot is spawned",
      'your token is for team red: choose a start of red',
    ],
    ["INIT: the connection's token has not the role driver; no robot is spawned", 'your token has not the role driver'],
    [
      '{ClassName USARBot.P3} is unknown; expected one of USARBot.A, USARBot.B; no robot is spawned',
      'the server has no class P3',
    ],
    [
      '{Location 1,2,3}: the object `barrel` takes it; no robot is spawned; GETSTARTPOSES names places to start at',
      'the object `barrel` takes it: choose another place',
    ],
    ['DRIVE ignored: there is no robot on this connection; send INIT first', null],
    ['{Start X} is unknown; expected one of Y; the origin is used', null],
  ]) {
    assert.equal(refusal(error), words);
  }
});

pageTest('a page removes a robot, and everyone hears who did it', { serve: ['--map', 'rough'] }, async (it) => {
  const { page, server } = it;
  assert.equal(await page.locator('#board').isVisible(), false);
  const client = await connectClient(server.port);
  client.send('INIT {ClassName USARBot.P3AT} {Name Ann}');
  await page.waitForSelector('[data-robot]', { state: 'attached' });
  await page.keyboard.press('Control+k');
  await page.keyboard.type('Remove the chosen');
  await page.keyboard.press('Enter');
  await page.waitForSelector('[data-robot]', { state: 'detached' });
  await page.waitForFunction(() => /removed robot 0 \(P3AT Ann\)/.test(document.querySelector('#toasts').textContent));
  client.end();
});
