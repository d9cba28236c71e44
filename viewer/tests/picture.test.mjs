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
      const [download] = await Promise.all([
        page.waitForEvent('download', { timeout: 60_000 }),
        page.click('#screenshot'),
      ]);
      const path = await download.path();
      assert.deepEqual(sizeOf(path), wanted);
      assert.ok(readFileSync(path).length > 30_000);
      // What is drawn goes on as it was.
      assert.equal(await drawn(), before);
    }
  },
);
