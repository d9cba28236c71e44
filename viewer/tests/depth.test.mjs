// What cameras show: victims in boxes, and depths as colours.

import assert from 'node:assert/strict';
import { countPixels, pageTest, waitForPixels } from './pagetest.mjs';
import { connectClient } from './server.mjs';

const rescue = { serve: ['--map', 'rescue'], page: { reducedMotion: 'reduce' } };

/** Red to yellow of what is near, which nothing else on the map has over such an area. */
const NEAR = [
  [150, 40, 10],
  [255, 230, 90],
];

pageTest('a victim in the picture of a camera has a box with its distance', rescue, async ({ page, server }) => {
  await connectClient(
    server.port,
    'INIT {ClassName USARBot.P3AT} {Name Finder} {Location -3,2.6,-0.2} {Rotation 0,0,1.5708}',
  );
  await page.click('[data-camera]');
  const box = await page.waitForSelector('[data-victim=maze]');
  const [, metres] = /maze (\d\.\d) m/.exec(await box.textContent());
  assert.ok(Math.abs(metres - 1.7) < 0.3, metres);
  const part = async (key) => Number.parseFloat(await box.evaluate((it, key) => it.style[key], key));
  const middle = (await part('left')) + (await part('width')) / 2;
  assert.ok(Math.abs(middle - 50) < 8, `${middle} % from the left`);
  // Behind walls none has a box.
  assert.deepEqual(await page.locator('[data-victim]').allTextContents(), [await box.textContent()]);
});

pageTest('depths are drawn as colours, with a scale', { serve: ['--map', 'hall'] }, async ({ page }) => {
  await page.keyboard.press('Escape');
  const before = await countPixels(page, ...NEAR);
  await page.click('#layers summary');
  await page.click('[name=depth]');
  await page.waitForSelector('#depths:has-text("m")');
  await waitForPixels(page, before + 20_000, ...NEAR);
  await page.click('[name=depth]');
  await page.waitForSelector('#depths', { state: 'hidden' });
  assert.equal(await page.evaluate(() => localStorage.getItem('usarsim.layers')?.includes('depth')), false);
});
