// Lines of the protocol that somebody types in the tab of the wire.

import assert from 'node:assert/strict';
import { pageTest, spawnRobot, X } from './pagetest.mjs';
import { waitForNumber } from './server.mjs';

const type = async (page, line) => {
  await page.fill('[name=line]', line);
  await page.keyboard.press('Enter');
};
const listed = (page, direction, text) => page.waitForSelector(`#lines .${direction}:has-text("${text}")`);

pageTest("a typed line is sent as the driven robot's client", {}, async ({ page }) => {
  await spawnRobot(page, { robotClass: 'P3AT' });
  await page.click('[data-tab=wire]');
  await page.focus('[name=line]');
  const suggested = await page.locator('#suggested-lines option').evaluateAll((all) => all.map(({ value }) => value));
  assert.ok(suggested.includes('DRIVE {Left 2} {Right 2}'), `${suggested}`);
  await type(page, 'DRIVE {Left 2} {Right 2}');
  await listed(page, 'in', 'DRIVE {Left 2} {Right 2}');
  await waitForNumber(page, X, (x) => x > 0.1);
  await type(page, 'DRIVE {Speed 2}');
  await listed(page, 'out', 'NFO {Error');
  for (const [key, line] of [
    ['ArrowUp', 'DRIVE {Speed 2}'],
    ['ArrowUp', 'DRIVE {Left 2} {Right 2}'],
    ['ArrowDown', 'DRIVE {Speed 2}'],
    ['ArrowDown', ''],
  ]) {
    await page.keyboard.press(key);
    assert.equal(await page.inputValue('[name=line]'), line);
  }
});

pageTest('typed lines spawn a robot by a client of their own', {}, async ({ page }) => {
  await page.click('[data-tab=wire]');
  await page.focus('[name=line]');
  const init = await page.locator('#suggested-lines option').first().getAttribute('value');
  assert.match(init, /^INIT /);
  await type(page, init);
  await page.waitForSelector('[data-robot]:has-text("Typed")', { state: 'attached' });
  await type(page, 'GETCONF {Type Nothing}');
  await listed(page, 'out', 'NFO {Error');
});
