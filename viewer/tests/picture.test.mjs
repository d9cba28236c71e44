// The picture that the page saves.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { pageTest, spawnRobot } from './pagetest.mjs';

/** Width and height of a PNG. */
function sizeOf(path) {
  const bytes = readFileSync(path);
  return [bytes.readUInt32BE(16), bytes.readUInt32BE(20)];
}

pageTest(
  'a saved picture has all pixels of the screen at every quality',
  { serve: ['--map', 'arena'], page: { viewport: { width: 1100, height: 500 }, deviceScaleFactor: 1.5 } },
  async ({ page }) => {
    await spawnRobot(page, { robotClass: 'P3AT' });
    const wanted = await page.locator('#canvas').evaluate(({ clientWidth, clientHeight }) => {
      return [Math.floor(1.5 * clientWidth), Math.floor(1.5 * clientHeight)];
    });
    const drawn = () => page.locator('#canvas').evaluate(({ width }) => width);
    for (const quality of [1, 5]) {
      await page.keyboard.press('Control+k');
      await page.fill('dialog input', `picture quality ${quality}`);
      await page.keyboard.press('Enter');
      await page.waitForFunction(
        (least) => document.querySelector('#canvas').width >= least,
        quality === 5 ? wanted[0] : 0,
      );
      const before = await drawn();
      const [download] = await Promise.all([page.waitForEvent('download'), page.click('#screenshot')]);
      const path = await download.path();
      assert.deepEqual(sizeOf(path), wanted);
      assert.ok(readFileSync(path).length > 30_000);
      // What is drawn goes on as it was.
      assert.equal(await drawn(), before);
    }
  },
);

pageTest('a picture of a camera stands over the view, is moved, and changes places', {}, async ({ page }) => {
  await spawnRobot(page, { robotClass: 'P3AT' });
  await page.click('[data-camera]');
  await page.waitForSelector('.picture img:not([hidden])');
  await page.click('.picture figcaption button');
  await page.waitForSelector('#view .inset img:not([hidden])');
  const box = () => page.locator('.inset').boundingBox();
  const before = await box();
  await page.mouse.move(before.x + 60, before.y + 12);
  await page.mouse.down();
  await page.mouse.move(before.x + 160, before.y - 38);
  await page.mouse.up();
  const dragged = await box();
  assert.deepEqual([dragged.x - before.x, dragged.y - before.y], [100, -50]);
  await page.focus('.inset header');
  await page.keyboard.press('ArrowDown');
  await page.keyboard.press('+');
  const moved = await box();
  assert.ok(moved.y > dragged.y && moved.width > dragged.width, JSON.stringify(moved));
  await page.dblclick('.inset .screen');
  await page.waitForFunction(() => document.querySelector('#camera').value === 'robot');
  await page.dblclick('.inset .screen');
  await page.waitForFunction(() => document.querySelector('#camera').value === 'orbit');
  await page.click('.inset header button');
  await page.waitForSelector('.picture img:not([hidden])');
  assert.equal(await page.locator('.inset').count(), 0);
});
