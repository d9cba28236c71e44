// What the first view shows, and how the page looks.

import assert from 'node:assert/strict';
import { pageTest, spawnRobot } from './pagetest.mjs';
import { PATIENCE, connectClient, waitForNumber } from './server.mjs';

const PHONE = { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true };

/** Waits until the scale says that so few metres are about 100 pixels. */
const waitForScale = (page, most) =>
  page.waitForFunction((most) => {
    const [, number, unit] = /([\d.]+) (cm|m)/.exec(document.querySelector('#scale').textContent) ?? [];
    return number && (unit === 'cm' ? number / 100 : Number(number)) <= most;
  }, most);

pageTest('a robot that is spawned is framed', { serve: ['--map', 'arena'] }, async ({ page }) => {
  assert.equal(await page.inputValue('select[name=class]'), 'YouBotArm');
  await page.click('#spawn');
  await page.waitForSelector('[data-robot]');
  // Half a metre in a hundred pixels is a robot of more than a hundred.
  await waitForScale(page, 0.5);
});

pageTest(
  'robots that are there are framed when the page opens',
  { serve: ['--map', 'arena'] },
  async ({ page, server }) => {
    await connectClient(server.port, 'INIT {ClassName USARBot.P3AT} {Name Robot1} {Start RobotStart1}');
    await page.waitForSelector('[data-robot]');
    await page.reload();
    await page.waitForFunction(() => document.documentElement.dataset.state === 'live');
    await waitForScale(page, 0.5);
  },
);

pageTest('the legend of a plot has the present numbers, and its axis a name and a unit', {}, async ({ page }) => {
  await spawnRobot(page, { robotClass: 'P3AT' });
  await page.click('[data-value=x]');
  await page.waitForSelector('figcaption:has-text("x (m)")');
  await page.keyboard.down('w');
  const value = '.u-legend .u-series:nth-child(2) .u-value';
  await waitForNumber(page, value, (x) => x > 0.2);
  await page.keyboard.up('w');
  assert.match(await page.textContent(value), / m$/);
  const isInside = await page.evaluate(() => {
    const [legend, panel] = ['.u-legend', '#plots'].map((it) => document.querySelector(it).getBoundingClientRect());
    return legend.bottom <= panel.bottom + 1;
  });
  assert.ok(isInside, 'the legend is not cut off');
});

pageTest('the fields of Wire are labelled', {}, async ({ page }) => {
  await page.click('[data-tab=wire]');
  const labels = await page
    .locator('#wire label')
    .evaluateAll((all) => all.map((label) => label.firstChild.textContent));
  assert.deepEqual(labels, ['Line', 'Filter', 'Lines', 'Client']);
  assert.deepEqual(await page.locator('[name=direction] option').allTextContents(), [
    'all',
    'from the client',
    'to the client',
  ]);
});

pageTest('the page does not say live when the connection is lost', { mayFail: true }, async ({ page, server }) => {
  await page.waitForSelector('#mode:text-is("live")');
  await server.stop('SIGKILL');
  await page.waitForSelector('#mode[data-mode=lost]:text-is("not connected")');
});

pageTest('a sheet on a phone leaves the view and its sticks', { page: PHONE }, async ({ page }) => {
  await page.tap('[data-spawn=P3AT]');
  await page.waitForSelector('#sticks:not([hidden])');
  const heights = await page
    .locator('#tools > button, #tools summary, #tools select')
    .evaluateAll((all) => all.map((it) => Math.round(it.getBoundingClientRect().height)));
  assert.equal(new Set(heights).size, 1, `${heights}`);
  await page.tap('[data-sheet=world]');
  const [stick, sheet] = await page.evaluate(() => [
    document.querySelector('[data-stick=move]').getBoundingClientRect().bottom,
    document.querySelector('#world').getBoundingClientRect().top,
  ]);
  assert.ok(stick <= sheet, `${stick} ${sheet}`);
  await page.tap('#layers summary');
  await page.waitForSelector('#layers[open]');
  await page.tap('#canvas', { position: { x: 60, y: 150 } });
  await page.waitForSelector('#layers:not([open])', { state: 'attached' });
});

pageTest('a phone has commands, keys and the picture in its sheet of time', { page: PHONE }, async ({ page }) => {
  await page.tap('[data-sheet=play]');
  assert.ok(await page.isVisible('#screenshot'));
  for (const [button, title] of [
    ['commands', 'Commands'],
    ['help', 'Keys'],
  ]) {
    await page.tap(`[data-press=${button}]`);
    await page.waitForSelector(`dialog[open]:has-text("${title}")`);
    await page.keyboard.press('Escape');
  }
  // Nothing is wider than the screen.
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
});

pageTest('in a frame the view has the room, and panels come when they are wanted', {}, async ({ page, server }) => {
  // Only the page of a program may be framed, as in a notebook.
  await page.route(server.url, async (route) => {
    const response = await route.fetch();
    const { 'content-security-policy': policy, ...headers } = response.headers();
    assert.match(policy, /frame-ancestors 'none'/);
    await route.fulfill({ response, headers });
  });
  const body = '<iframe src="/" width="900" height="480"></iframe>';
  await page.route(`${server.url}notebook`, (route) => route.fulfill({ contentType: 'text/html', body }));
  await page.goto(`${server.url}notebook`);
  const frame = page.frameLocator('iframe');
  await frame.locator('html[data-framed][data-state=live]').waitFor();
  const part = await frame.locator('#view').evaluate((view) => view.clientHeight / innerHeight);
  const across = await frame.locator('#view').evaluate((view) => view.clientWidth / innerWidth);
  assert.ok(across > 0.98 && part > 0.8, `${across} ${part}`);
  await frame.locator('#panels').click();
  await frame.locator('#world').waitFor();
});

pageTest('a robot that is driven out of the view takes the view along', {}, async ({ page }) => {
  await spawnRobot(page, { robotClass: 'AirRobot' });
  assert.equal(await page.inputValue('#camera'), 'orbit');
  await page.keyboard.down('r');
  await waitForNumber(page, '[data-value=z]', (z) => z < -0.5);
  // It leaves the view between two pictures.
  await page.evaluate(() => {
    for (const end = performance.now() + 4000; performance.now() < end;);
  });
  await waitForNumber(page, '[data-value=z]', (z) => z < -8);
  await page.keyboard.up('r');
  // Its name would be hidden beside the view.
  await page.waitForFunction(() => {
    const label = document.querySelector('.view-label.robot');
    const [inner, outer] = [label, document.querySelector('#canvas')].map((it) => it.getBoundingClientRect());
    return Number(label.style.opacity) > 0 && inner.top > outer.top && inner.bottom < outer.bottom;
  });
});

pageTest('propellers turn while a robot hovers', {}, async ({ page }) => {
  await spawnRobot(page, { robotClass: 'AirRobot' });
  await waitForScale(page, 0.5);
  await page.keyboard.press('Space');
  const box = await page.locator('#canvas').boundingBox();
  const clip = { x: box.x + box.width / 2 - 150, y: box.y + box.height / 2 - 100, width: 300, height: 200 };
  let shown = await page.screenshot({ clip });
  const waitUntil = async (same) => {
    for (const end = performance.now() + PATIENCE; performance.now() < end; await page.waitForTimeout(300)) {
      const before = shown;
      shown = await page.screenshot({ clip });
      if (shown.equals(before) === same) return;
    }
    throw new Error(`the view ${same ? 'changes' : 'is the same'} for ${PATIENCE / 1000} s`);
  };
  await waitUntil(true);
  for (let step = 0; step < 5; step++) await page.keyboard.press('.');
  await waitUntil(false);
});
