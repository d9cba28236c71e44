// A test with a server and a page of its own.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { launchBrowser, openPage, pictures, startServer } from './server.mjs';

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
export function pageTest(name, { serve = [], page: options = {}, mayFail = false }, body) {
  test(name, { timeout: 120_000 }, async () => {
    const server = await startServer(...serve);
    const { page, errors, seconds } = await openPage(browser, server.url, options);
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
