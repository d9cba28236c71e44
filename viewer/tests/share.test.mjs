// What is shown here is shown to others: a link, a picture of any size, a clip.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { runnerImport } from 'vite';
import { ABOVE, X, Y, pageTest, spawnRobot, waitForView } from './pagetest.mjs';
import { openPage, root, startServer, waitForNumber } from './server.mjs';

const { readLink, writeLink } = (await runnerImport(join(root, 'viewer/src/link.ts'))).module;
const rough = { serve: ['--map', 'rough'], page: { reducedMotion: 'reduce' } };

test('a link is read as it was written, and a wrong one brings what is right of it', () => {
  const link = {
    map: 'my hall',
    robots: [{ robotClass: 'P3AT', location: [1, -2.5, -0.145], yaw: 1.571 }],
    camera: { from: [8, -6, -4], at: [0.5, 0, 0] },
    log: { name: 'run 1&2.mcap', time: 83.25 },
  };
  assert.deepEqual(readLink(`#${writeLink(link)}`), link);
  for (const nothing of [
    '',
    '#',
    '#scenario=stairs',
    '#token=abc',
    '#camera=1,2,3',
    '#camera=1,2,3,4,5,1e9',
    '#robots=P3AT',
    '#t=5',
  ])
    assert.equal(readLink(nothing), null, nothing);
  const many = Array.from({ length: 1000 }, () => 'P3AT@0,0,0,0').join(';');
  assert.equal(readLink(`#robots=${many};<b>@0,0,0,0`).robots.length, 20);
});

pageTest('a link opens the same map, robots and view on another server', rough, async ({ page }) => {
  await spawnRobot(page, { robotClass: 'P3AT', start: 'RobotStart1' });
  await page.selectOption('#camera', 'top');
  await waitForView(page, ABOVE);
  await page.click('#share');
  const link = new URL(await page.inputValue('#share-link'));
  const [x, y] = [await page.textContent(X), await page.textContent(Y)];
  const other = await startServer('--map', 'hall');
  const { page: opened, errors } = await openPage(page.context().browser(), `${other.url}${link.hash}`, { door: true });
  await opened.waitForSelector('#map:text-is("rough")');
  await opened.waitForSelector('[data-robot]:has-text("P3AT")', { state: 'attached' });
  await waitForView(opened, ABOVE);
  await waitForNumber(opened, X, (value) => Math.abs(value - x) < 0.1);
  await waitForNumber(opened, Y, (value) => Math.abs(value - y) < 0.1);
  assert.equal(await opened.evaluate(() => document.documentElement.dataset.door), undefined);
  assert.deepEqual(errors, []);
  await opened.context().close();
  await other.stop();
});

/** Clicks and returns the file that the page gives. */
async function download(page, selector) {
  const [file] = await Promise.all([page.waitForEvent('download'), page.click(selector)]);
  return { name: file.suggestedFilename(), bytes: readFileSync(await file.path()) };
}

pageTest('a picture has the size that is chosen, and the view its own again', rough, async ({ page }) => {
  await spawnRobot(page);
  const size = () => page.evaluate(() => ['width', 'height'].map((side) => document.querySelector('#canvas')[side]));
  const before = await size();
  await page.click('#share');
  await page.selectOption('#share-size', '1080,1080');
  const { name, bytes } = await download(page, '#share-picture');
  assert.match(name, /^usarsim-rough-[\d.]+s\.png$/);
  assert.deepEqual([bytes.readUInt32BE(16), bytes.readUInt32BE(20)], [1080, 1080]);
  assert.deepEqual(await size(), before);
});

pageTest('a time of the run is saved as a clip, and the present comes back', rough, async ({ page }) => {
  await spawnRobot(page);
  await page.keyboard.down('w');
  await waitForNumber(page, X, (value) => value > 0.4);
  await page.keyboard.up('w');
  await page.click('#share');
  await page.fill('[aria-label=From]', '9');
  await page.fill('[aria-label=To]', '8');
  await page.click('#share-clip');
  await page.waitForSelector('#toasts :text("A clip ends after it begins")');
  const last = Number(/and ([\d.]+) s/.exec(await page.textContent('dialog'))[1]);
  await page.fill('[aria-label=From]', String(last - 1));
  await page.fill('[aria-label=To]', String(last));
  const { name, bytes } = await download(page, '#share-clip');
  assert.match(name, /\.webm$/);
  // EBML, and some pictures.
  assert.equal(bytes.readUInt32BE(0), 0x1a45dfa3);
  assert.ok(bytes.length > 5000, `${bytes.length} bytes`);
  await page.waitForSelector('#timeline[data-live]');
});
