// The first screen: scenarios as cards, their demos, and what becomes of them.

import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pageTest } from './pagetest.mjs';
import { connectClient, number, until, waitForNumber } from './server.mjs';

const door = { door: true };
const isOpen = (page) => page.evaluate(() => document.documentElement.dataset.door === 'open');

/** A folder with a scenario that is done a metre ahead, and its demo. */
function ownScenarios() {
  const folder = mkdtempSync(join(tmpdir(), 'usarsim-'));
  mkdirSync(join(folder, 'ahead'));
  const zone = '[[zone]]\nname = "a-metre-ahead"\nposition = [1.5, 0, 0]\nsize = [1, 1, 2]\n';
  const head =
    'title = "Ahead"\ntext = "Drive."\nkeys = "W"\nmap = "smooth"\ntime_limit = 60\nstars = [30, 50]\nrank = 0\n';
  const robot = '[[robot]]\nclass = "P3AT"\nposition = [0, 0, 0]\n';
  writeFileSync(join(folder, 'ahead/scenario.toml'), head + robot + zone);
  const lines = '0 1 INIT {ClassName USARBot.P3AT}\n0.1 1 DRIVE {Left 5} {Right 5}\n';
  writeFileSync(join(folder, 'ahead/demo.txt'), lines);
  return folder;
}

const serve = ['--scenarios', ownScenarios()];

pageTest('the page opens with scenarios before the demo of the chosen one', { serve, page: door }, async ({ page }) => {
  await page.waitForSelector('#door [data-scenario=ahead][aria-pressed=true]');
  assert.equal(await page.locator('#door [data-scenario]').count(), 11);
  // The demo runs behind the cards, in a world of its own: the server's has no robot.
  await page.waitForFunction(() => document.querySelector('[data-robot] span')?.textContent.includes('P3AT'));
  await waitForNumber(page, '#time', (time) => time > 0.5);
  await page.hover('[data-scenario=cube]');
  await page.waitForSelector('[data-scenario=cube][aria-pressed=true]');
  assert.equal(await page.textContent('#door h2'), 'Pick the cube');
  await page.waitForFunction(() => document.querySelector('[data-robot] span')?.textContent.includes('YouBotArm'));
  await page.keyboard.press('Escape');
  await page.waitForFunction(() => document.documentElement.dataset.door === undefined);
  // The world is as it was, without a robot, and stays so in this tab.
  await page.waitForSelector('#welcome:not([hidden])');
  assert.equal(await page.locator('[data-robot]').count(), 0);
  await page.reload();
  await page.waitForSelector('#welcome:not([hidden])');
  assert.equal(await isOpen(page), false);
  await page.keyboard.press('t');
  await page.waitForSelector('#door:not([hidden])');
});

pageTest(
  'a demo plays again after its end, and a card that is chosen then is shown',
  { serve, page: door },
  async ({ page }) => {
    await page.waitForFunction(() => document.querySelector('[data-robot] span')?.textContent.includes('P3AT'));
    // The demo stands at its end for a while, and starts again.
    await page.waitForSelector('#mode[data-mode=log]', { state: 'attached' });
    await page.waitForSelector('#pause[aria-pressed=true]', { state: 'attached' });
    await page.waitForSelector('#pause[aria-pressed=false]', { state: 'attached' });
    await page.waitForSelector('#pause[aria-pressed=true]', { state: 'attached' });
    await page.hover('[data-scenario=cube]');
    await page.waitForFunction(() => document.querySelector('[data-robot] span')?.textContent.includes('YouBotArm'));
  },
);

pageTest('a scenario is begun, driven to its goal, and its best run kept', { serve, page: door }, async ({ page }) => {
  await page.click('#door-start');
  await page.waitForSelector('[data-robot]', { state: 'attached' });
  await page.waitForSelector('#mission li[data-goal=a-metre-ahead]:not(.done)');
  await page.keyboard.down('w');
  await page.waitForSelector('#mission.finished');
  await page.keyboard.up('w');
  assert.match(await page.textContent('#mission .result'), /^★★★ in 0:\d\d\.\d\. Your best\.$/);
  assert.equal(await page.locator('#mission .done').count(), 1);
  const kept = await page.evaluate(() => [localStorage['usarsim.best.ahead'], localStorage['usarsim.run.ahead']]);
  const [best, poses] = [Number(kept[0]), JSON.parse(kept[1])];
  // A pose for each fifth of a second, from the start to the goal.
  assert.ok(Math.abs(poses.length - best / 0.2) < 8 && poses[0][0] < 0.1 && poses.at(-1)[0] > 0.9, kept.join());
  // Another scenario does not get its time.
  await page.click('#mission-others');
  await page.click('[data-scenario=slalom]');
  await page.click('#door-start');
  await page.waitForSelector('#mission:has-text("slalom"):not(.finished)');
  await page.waitForSelector('[data-robot]:has-text("YouBot")', { state: 'attached' });
  assert.equal(await page.evaluate(() => localStorage['usarsim.best.slalom']), undefined);
  await page.click('#mission-others');
  await page.click('[data-scenario=ahead]');
  await page.click('#door-start');
  await page.waitForSelector('#mission:has-text("Ahead")');
  await page.waitForSelector('[data-robot]:has-text("P3AT")', { state: 'attached' });
  await page.click('#mission-again');
  await page.waitForSelector('#mission:not(.finished)');
  await page.waitForFunction(() => document.querySelector('#mission .result').textContent.includes('Your best is'));
  await page.waitForSelector('[data-robot]', { state: 'attached' });
  // The cards stay open over a world with robots, which drives on.
  await page.click('#mission-others');
  await waitForNumber(page, '#time', (time) => time > 1.5);
  assert.equal(await isOpen(page), true);
  await page.keyboard.press('Escape');
  await page.waitForSelector('#mission:not([hidden])');
});

pageTest('watching a scenario done plays its demo as a log', { serve, page: door }, async ({ page }) => {
  await page.click('#door-watch');
  await page.waitForSelector('#past:not([hidden])');
  assert.match(await page.textContent('#past'), /the log ahead\.mcap/);
  assert.equal(await isOpen(page), false);
  await page.click('[data-tab=wire]');
  await page.waitForFunction(() => document.querySelector('#wire').textContent.includes('DRIVE {Left 5} {Right 5}'));
  await page.click('#live');
  await page.waitForSelector('#door:not([hidden])');
});

pageTest(
  'a controller that comes finds the world, and the cards go',
  { serve, page: door },
  async ({ page, server }) => {
    // It comes while the demo is fetched, opened or shown.
    await page.waitForSelector('#door:not([hidden])');
    const client = await connectClient(server.port, 'INIT {ClassName USARBot.P3AT} {Name Ann} {Location 1,1,0}');
    await page.waitForFunction(() => document.documentElement.dataset.door === undefined);
    await page.waitForFunction(() => document.querySelector('[data-robot] span')?.textContent.includes('Ann'));
    assert.equal(await page.textContent('#map'), 'hall');
    client.end();
  },
);

pageTest(
  'who may not control the world looks at demos and begins nothing',
  { serve: [...serve, '--control', 'nobody'], page: door },
  async ({ page }) => {
    await page.click('#door-start');
    await page.waitForFunction(() => document.querySelector('#toasts').textContent.includes('no page controls'));
    assert.equal(await isOpen(page), true);
  },
);

pageTest('a league opens at once', { serve: ['--league', 'rescue'], page: door }, async ({ page }) => {
  await page.waitForSelector('#board:not([hidden])');
  assert.deepEqual([await isOpen(page), await page.isVisible('#scenarios')], [false, false]);
});

pageTest(
  'a scenario of the server waits for its robot',
  { serve: ['--scenario', 'slalom'], page: door },
  async ({ page }) => {
    await page.click('#mission-enter');
    await page.waitForSelector('[data-robot]', { state: 'attached' });
    await until(async () => (await number(page, '#mission-time')) >= 0);
    assert.equal(await page.locator('#mission [data-goal]').count(), 4);
  },
);

pageTest('a scenario that is begun while its demo is on its way is shown', { serve, page: door }, async ({ page }) => {
  // The scene of the demo's log comes after the scenario has begun.
  let began;
  const hasBegun = new Promise((resolve) => (began = resolve));
  await page.route('**/scene.json', async (route) => {
    if (route.request().method() === 'POST') await hasBegun;
    await route.continue();
  });
  const asked = page.waitForRequest((request) => request.method() === 'POST' && request.url().includes('scene.json'));
  await page.hover('[data-scenario=goal]');
  await asked;
  await page.click('[data-scenario=ahead]');
  await page.click('#door-start');
  await page.waitForSelector('[data-robot]', { state: 'attached' });
  began();
  await page.waitForSelector('#mission li[data-goal=a-metre-ahead]');
  await waitForNumber(page, '#mission-time', (value) => value >= 0);
  assert.equal(await page.isVisible('#past'), false);
});

pageTest(
  'a run of somebody else is no best of this browser',
  { serve: [...serve, '--scenario', `${serve[1]}/ahead`], page: door },
  async ({ page, server }) => {
    const client = await connectClient(server.port, 'INIT {ClassName USARBot.P3AT}', 'DRIVE {Left 5} {Right 5}');
    await page.waitForSelector('#mission.finished');
    assert.match(await page.textContent('#mission .result'), /^★★★ in 0:\d\d\.\d\.$/);
    assert.equal(await page.evaluate(() => localStorage['usarsim.best.ahead']), undefined);
    client.end();
  },
);

pageTest('scenarios of one map follow each other, and one begins again', { page: door }, async ({ page }) => {
  // The server's own map is the hall, as those of these scenarios are.
  for (const [name, title, robot] of [
    ['cube', 'Pick the cube', 'YouBotArm'],
    ['survey', 'Map the hall', 'P3AT'],
    ['survey', 'Map the hall', 'P3AT'],
  ]) {
    await page.waitForSelector('#scenarios:not([hidden])');
    if (!(await isOpen(page))) await page.click('#scenarios');
    await page.click(`[data-scenario=${name}]`);
    await page.click('#door-start');
    await page.waitForSelector(`#mission:not([hidden]) h2:text-is("${title}")`);
    await page.waitForSelector(`[data-robot] span:text-is("${robot}")`, { state: 'attached' });
    await waitForNumber(page, '#mission-time', (value) => value >= 0);
    // It is this page's own: nobody is asked before the next one.
    await page.waitForSelector('[data-robot]:has-text("yours")', { state: 'attached' });
    await page.waitForSelector('#mission-enter', { state: 'hidden' });
  }
});
