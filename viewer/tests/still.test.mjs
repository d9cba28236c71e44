// The still picture at the best quality that covers a view in which nothing moves.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { runnerImport } from 'vite';
import { ABOVE, near, pageTest, setQuality, spawnRobot, waitForPixels, waitForView } from './pagetest.mjs';
import { root } from './server.mjs';

const shown = (page) => page.waitForSelector('.view-still.shown');
const gone = (page) => page.waitForSelector('.view-still:not(.shown)', { state: 'attached' });

const auto = { page: { quality: 'auto' } };

pageTest('a view at rest is drawn at the best quality, and gives way to motion', auto, async ({ page }) => {
  await shown(page);
  await page.waitForFunction(() => document.querySelector('#rate').textContent === 'Picture quality 5 of 5');
  await spawnRobot(page, { robotClass: 'P3AT' });
  await shown(page);
  await page.keyboard.down('w');
  await gone(page);
  await page.keyboard.up('w');
  await shown(page);
  const box = await page.locator('#canvas').boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.wheel(0, -200);
  await gone(page);
  await shown(page);
});

pageTest(
  'a still picture has as many pixels as the screen',
  { page: { deviceScaleFactor: 2, quality: 'auto' } },
  async ({ page }) => {
    await shown(page);
    const [drawn, wanted] = await page.evaluate(() => {
      const [still, canvas] = ['.view-still', '#canvas'].map((it) => document.querySelector(it));
      return [still.width / canvas.clientWidth, window.devicePixelRatio];
    });
    assert.equal(drawn, wanted);
  },
);

pageTest('a rung of quality that somebody holds has no still picture, and is kept', auto, async ({ page }) => {
  await setQuality(page, 1);
  await page.reload();
  await page.waitForFunction(() => document.documentElement.dataset.state === 'live');
  await page.keyboard.press('Home');
  await gone(page);
  await page.waitForFunction(() => /^Picture quality 1 of 5$/.test(document.querySelector('#rate').textContent));
  // Longer than it would take to begin one.
  await page.evaluate(
    () =>
      new Promise((done) => {
        const end = performance.now() + 1000;
        const frame = (now) => (now > end ? done() : requestAnimationFrame(frame));
        requestAnimationFrame(frame);
      }),
  );
  assert.equal(await page.locator('.view-still.shown').count(), 0);
});

pageTest('the dark theme leaves the world its light', auto, async ({ page }) => {
  await shown(page);
  const still = () => page.evaluate(() => document.querySelector('.view-still').toDataURL());
  const light = await still();
  await page.click('#theme');
  await page.waitForFunction(() => document.documentElement.dataset.theme === 'dark');
  assert.equal(await page.locator('.view-still.shown').count(), 1);
  assert.equal(await still(), light);
  assert.equal(await page.evaluate(() => getComputedStyle(document.querySelector('#world')).colorScheme), 'dark');
});

pageTest('walls have shadows on the floor at a low quality', { serve: ['--map', 'factory'] }, async ({ page }) => {
  await setQuality(page, 2);
  await page.selectOption('#camera', 'top');
  await waitForView(page, ABOVE);
  // The floor in the shade.
  await waitForPixels(page, 6000, ...near('#77746e', 10));
});

test('free rollers that turn on after a robot has stopped are no motion where nobody sees them', async () => {
  const { module } = await runnerImport(join(root, 'viewer/src/view/moved.ts'));
  const frame = (angle, turn) => {
    const robot = { id: 1, pose: [0, 0, 0, 0, 0, 0, 1], links: [], wheels: [{ angle, rollers: [turn] }], contacts: [] };
    return { robots: [robot], objects: [], pulls: [] };
  };
  const moves = (after, rollers) => module.moved(frame(0, 0), after, { forces: false, rollers });
  assert.deepEqual(
    [moves(frame(0, 0.5), false), moves(frame(0, 0.5), true), moves(frame(0.1, 0), false), moves(frame(0, 0), true)],
    [false, true, true, false],
  );
});
