// A test with a server and a page of its own.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { PATIENCE, launchBrowser, openPage, pictures, startServer, until } from './server.mjs';

export const X = '[data-value=x]';
export const Y = '[data-value=y]';
let browser;

before(async () => {
  browser = await launchBrowser();
});

after(async () => {
  await browser.close();
});

/** Nothing may go to the console as an error. */
export function pageTest(name, { serve = [], path = '', page: options = {}, mayFail = false }, body) {
  test(name, { timeout: 3 * PATIENCE }, async () => {
    const server = await startServer(...serve);
    const { page, errors, seconds } = await openPage(browser, server.url + path, options);
    try {
      await body({ page, server, seconds });
      await page.screenshot({ path: join(pictures, `${name.replaceAll(/\W+/g, '-')}.png`) });
    } finally {
      await page.context().close();
      await server.stop();
    }
    if (!mayFail) assert.deepEqual(errors, []);
  });
}

export async function spawnRobot(page, { robotClass = 'KUKA_YouBot', start = 'PlayerStart_0' } = {}) {
  await page.click('[data-tab=drive]');
  await page.selectOption('select[name=class]', robotClass);
  await page.selectOption('select[name=start]', start);
  await page.click('#spawn');
  await page.waitForSelector('[data-robot]', { state: 'attached' });
}

/** Counts the pixels of the view whose red, green and blue are between limits. */
export async function countPixels(page, least, most) {
  const picture = (await page.locator('#canvas').screenshot()).toString('base64');
  return page.evaluate(
    async ([picture, least, most]) => {
      const bytes = Uint8Array.from(atob(picture), (byte) => byte.charCodeAt(0));
      const bitmap = await createImageBitmap(new Blob([bytes]));
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
      context.drawImage(bitmap, 0, 0);
      const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
      const fits = (at) => [0, 1, 2].every((part) => least[part] <= data[at + part] && data[at + part] <= most[part]);
      let count = 0;
      for (let at = 0; at < data.length; at += 4) if (fits(at)) count++;
      return count;
    },
    [picture, least, most],
  );
}

/** Waits until so many pixels are of a colour. */
export async function waitForPixels(page, count, least, most) {
  let found = 0;
  const areThere = async () => (found = await countPixels(page, least, most)) >= count;
  await until(areThere, () => `${found} pixels, expected ${count}`);
}

/** Returns the limits of red, green and blue about a colour. */
export function near(colour, by) {
  const parts = [1, 3, 5].map((at) => Number.parseInt(colour.slice(at, at + 2), 16));
  const limited = (by) => parts.map((part) => Math.max(0, Math.min(255, part + by)));
  return [limited(-by), limited(by)];
}

export async function setQuality(page, quality) {
  await page.keyboard.press('Control+k');
  await page.fill('dialog input', `picture quality ${quality}`);
  await page.keyboard.press('Enter');
  await page.waitForFunction(
    (quality) => document.querySelector('#rate').textContent.startsWith(`Picture quality ${quality} of 5`),
    quality,
  );
}

/** Length of the vertical axis in the drawing of the axes, px: the camera's pitch. */
export const ABOVE = [0, 1];
export const SLANTED = [8, 26];

/** Waits until the camera is so far above what it looks at. */
export function waitForView(page, [least, most]) {
  return page.waitForFunction(
    ([least, most]) => {
      const [ball] = [...document.querySelectorAll('.view-gizmo .ball')].filter(
        (ball) => ball.querySelector('title').textContent === 'Look from +z',
      );
      const [x, y] = (ball?.getAttribute('transform') ?? '').match(/-?[\d.]+/g)?.map(Number) ?? [];
      const length = Math.hypot(x - 42, y - 42);
      return least <= length && length <= most;
    },
    [least, most],
  );
}

/** Waits until the only robot's or the chosen robot's name is near the middle of the view. */
export function waitForRobotInMiddle(page, most = 70) {
  return page.waitForFunction((most) => {
    const name = document.querySelector('[data-robot][aria-pressed=true] span')?.textContent;
    const label = [...document.querySelectorAll('.view-label.robot')].find(({ textContent }) => textContent === name);
    const { width, height } = document.querySelector('#canvas').getBoundingClientRect();
    const [x, y] = label?.style.transform.match(/-?[\d.]+/g)?.map(Number) ?? [];
    return Math.hypot(x + label?.offsetWidth / 2 - width / 2, y - height / 2) < most;
  }, most);
}
