// Makes the pictures of scenarios' cards, scenarios/*/picture.jpg, from their demos: `npm run cards [NAME ..]`, with the release build there.

import { readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { launchBrowser, openPage, root, startServer, waitForNumber } from './server.mjs';

/** Simulated times at which the demos are looked at, s. */
const MOMENTS = {
  stairs: 12.5,
  cube: 14,
  victims: 33,
  slalom: 9,
  crate: 6,
  goal: 7,
  parking: 11.5,
  survey: 21,
  flight: 8.5,
  sideways: 7,
};
const [WIDTH, HEIGHT] = [320, 200];

const wanted = process.argv.slice(2);
const folders = readdirSync(join(root, 'scenarios'), { withFileTypes: true }).filter((entry) => entry.isDirectory());
const browser = await launchBrowser();
// The folder's own files, which may be newer than those in the program.
const server = await startServer('--scenarios', join(root, 'scenarios'));
for (const { name } of folders) {
  if (wanted.length > 0 && !wanted.includes(name)) continue;
  const { page } = await openPage(browser, server.url, { door: true, quality: 'auto', colorScheme: 'light' });
  await page.click(`[data-scenario=${name}]`);
  await page.click('#door-watch');
  await page.waitForSelector('#past:not([hidden])');
  await page.selectOption('#speed', '2');
  await waitForNumber(page, '#time', (value) => value >= (MOMENTS[name] ?? 5));
  await page.click('#pause');
  await page.addStyleTag({ content: '#view > :not(canvas) { visibility: hidden !important }' });
  await page.waitForSelector('.view-still.shown', { state: 'attached', timeout: 60_000 });
  await page.waitForTimeout(1000);
  const { x, y, width, height } = await page.locator('#view').boundingBox();
  const part = Math.min(height, (width * HEIGHT) / WIDTH);
  const clip = { x, y: y + (height - part) / 2, width, height: part };
  const shot = (await page.screenshot({ clip })).toString('base64');
  const picture = await page.evaluate(
    async ([shot, width, height]) => {
      const bytes = Uint8Array.from(atob(shot), (byte) => byte.charCodeAt(0));
      const bitmap = await createImageBitmap(new Blob([bytes]), {
        resizeWidth: width,
        resizeHeight: height,
        resizeQuality: 'high',
      });
      const canvas = new OffscreenCanvas(width, height);
      canvas.getContext('2d').drawImage(bitmap, 0, 0);
      const jpeg = await (await canvas.convertToBlob({ type: 'image/jpeg', quality: 0.82 })).arrayBuffer();
      return btoa(String.fromCharCode(...new Uint8Array(jpeg)));
    },
    [shot, WIDTH, HEIGHT],
  );
  writeFileSync(join(root, 'scenarios', name, 'picture.jpg'), Buffer.from(picture, 'base64'));
  console.log(name);
  await page.context().close();
}
await server.stop();
await browser.close();
