// The score board of a league.

import assert from 'node:assert/strict';
import { mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pageTest } from './pagetest.mjs';
import { connectClient } from './server.mjs';

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
