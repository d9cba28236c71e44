// What axe-core finds of WCAG 2.2 AA in every state of the page, light and dark, wide and on a phone.

import assert from 'node:assert/strict';
import axe from 'axe-core';
import { pageTest, spawnRobot } from './pagetest.mjs';
import { waitForNumber } from './server.mjs';

const TAGS = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'];
const PHONE = { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true };

/** What is found, each with where. The page's own scripts only may run, so axe comes in by the debugger. */
async function findings(page, state) {
  await page.evaluate(axe.source);
  const { violations } = await page.evaluate(
    (values) => window.axe.run(document, { runOnly: { type: 'tag', values } }),
    TAGS,
  );
  return violations.map(
    ({ id, impact, nodes }) => `${state}: ${impact} ${id}: ${nodes.map(({ target }) => target).join(' ')}`,
  );
}

for (const colorScheme of ['light', 'dark']) {
  pageTest(
    `nothing is found in ${colorScheme} colours`,
    { serve: ['--map', 'arena'], page: { colorScheme } },
    async ({ page }) => {
      const found = await findings(page, 'no robot');
      await spawnRobot(page, { robotClass: 'YouBotArm' });
      await waitForNumber(page, '#time', (value) => value > 1);
      await page.click('#toggle-plots');
      found.push(...(await findings(page, 'a robot and plots')));
      await page.click('#tab-wire');
      await page.waitForSelector('#lines li');
      found.push(...(await findings(page, 'wire')));
      for (const open of ['#map', '#help', '#commands']) {
        await page.click(open);
        found.push(...(await findings(page, open)));
        await page.keyboard.press('Escape');
      }
      assert.deepEqual(found, []);
    },
  );
  pageTest(
    `nothing is found on the first screen in ${colorScheme} colours`,
    { page: { colorScheme, door: true } },
    async ({ page }) => {
      await page.waitForSelector('#door:not([hidden])');
      const found = await findings(page, 'cards');
      await page.click('#door-start');
      await page.waitForSelector('#mission:not([hidden])');
      await page.waitForSelector('[data-robot]', { state: 'attached' });
      found.push(...(await findings(page, 'scenario')));
      assert.deepEqual(found, []);
    },
  );
  pageTest(
    `nothing is found on a phone in ${colorScheme} colours`,
    { page: { ...PHONE, colorScheme } },
    async ({ page }) => {
      const found = await findings(page, 'no robot');
      await page.tap('[data-spawn=P3AT]');
      await page.waitForSelector('[data-robot]', { state: 'attached' });
      for (const sheet of ['world', 'drive', 'plots', 'wire', 'play']) {
        await page.tap(`[data-sheet=${sheet}]`);
        assert.ok(
          await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth),
          `${sheet} is not cut off`,
        );
        found.push(...(await findings(page, sheet)));
        await page.tap(`[data-sheet=${sheet}]`);
      }
      assert.deepEqual(found, []);
    },
  );
}

for (const [size, page] of [
  ['a screen', {}],
  ['a phone', PHONE],
  ['a small phone', { ...PHONE, viewport: { width: 320, height: 640 } }],
]) {
  pageTest(`the first view's robots stay on their cards on ${size}`, { page }, async ({ page }) => {
    await page.waitForFunction(() => [...document.querySelectorAll('.card img')].every(({ complete }) => complete));
    const outside = await page.evaluate(() => {
      const isInside = (one, other) => {
        const [a, b] = [one, other].map((element) => element.getBoundingClientRect());
        return a.left >= b.left && a.right <= b.right && a.top >= b.top && a.bottom <= b.bottom;
      };
      const pairs = [...document.querySelectorAll('.card')].flatMap((card) => [
        [card, card.closest('#welcome')],
        ...[...card.children].map((child) => [child, card]),
      ]);
      const scale = document.querySelector('#scale').getBoundingClientRect();
      const covers = document.querySelector('#welcome').getBoundingClientRect().bottom > scale.top;
      return [
        ...pairs.filter(([one, other]) => !isInside(one, other)).map(([one]) => one.outerHTML),
        ...(covers ? ['the scale'] : []),
      ];
    });
    assert.deepEqual(outside, []);
    assert.equal(await page.locator('.card img').count(), 3);
  });
}
