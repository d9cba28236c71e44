// Makes the pictures of the page in docs/pictures: `npm run pictures`, with the release build there.

import { join } from 'node:path';
import { connectRobots, launchBrowser, openPage, root, startServer, waitForNumber } from './server.mjs';

const folder = join(root, 'docs/pictures');
const browser = await launchBrowser();

async function take(file, serve, options, prepare) {
  const server = await startServer(...serve);
  const { page } = await openPage(browser, server.url, options);
  await prepare(page, server);
  // Messages would hide the view, and who uses no keyboard sees no focus.
  await page.evaluate(() => {
    document.getElementById('toasts').replaceChildren();
    document.activeElement.blur();
  });
  await page.screenshot({ path: join(folder, file) });
  await page.context().close();
  await server.stop();
}

async function drive(page, key, robotClass = 'YouBotArm') {
  await page.click(`[data-spawn=${robotClass}]`);
  await page.waitForSelector('[data-robot]', { state: 'attached' });
  await page.keyboard.down(key);
}

const wide = { viewport: { width: 1280, height: 800 }, colorScheme: 'light' };
const phone = { viewport: { width: 390, height: 780 }, colorScheme: 'light', hasTouch: true, isMobile: true };

await take('page.png', ['--map', 'arena'], wide, async (page, server) => {
  await drive(page, 'w', 'P3AT');
  await connectRobots(server.port, 5, 'YouBot');
  await connectRobots(server.port, 1, 'Kenaf');
  await page.click('[data-robot="0"]');
  await waitForNumber(page, '[data-value=x]', (value) => value > 1.2);
  await page.click('#fit');
  await page.waitForTimeout(1500);
});
await take('plots.png', ['--map', 'rough'], wide, async (page) => {
  await drive(page, 'd');
  await page.click('#toggle-plots');
  await waitForNumber(page, '#time', (value) => value > 8);
});
await take('phone.png', ['--map', 'rough'], phone, async (page) => {
  await drive(page, 'd');
  await waitForNumber(page, '#time', (value) => value > 3);
});
await browser.close();
