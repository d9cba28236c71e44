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

/** Returns the part of a PNG's pixels that are transparent, and that of white ones. */
function partsOf(page, bytes) {
  return page.evaluate(async (text) => {
    const data = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([data]));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const pixels = context.getImageData(0, 0, bitmap.width, bitmap.height).data;
    let [clear, white] = [0, 0];
    for (let at = 0; at < pixels.length; at += 4) {
      if (pixels[at + 3] < 10) clear++;
      else if (Math.min(pixels[at], pixels[at + 1], pixels[at + 2]) > 235) white++;
    }
    return { clear: (4 * clear) / pixels.length, white: (4 * white) / pixels.length };
  }, bytes.toString('base64'));
}

pageTest('a picture has floor, background and labels as they are chosen', rough, async ({ page }) => {
  await spawnRobot(page, { robotClass: 'P3AT' });
  await page.waitForFunction(() => Number(document.querySelector('.view-label.robot')?.style.opacity) > 0.9);
  const picture = async (...boxes) => {
    await page.click('#share');
    for (const box of ['grid', 'floor', 'background', 'labels'])
      await page.setChecked(`dialog [name=${box}]`, boxes.includes(box));
    const { bytes } = await download(page, '#share-picture');
    await page.keyboard.press('Escape');
    return partsOf(page, bytes);
  };
  const whole = await picture('floor', 'background');
  assert.equal(whole.clear, 0);
  const labelled = await picture('floor', 'background', 'labels');
  assert.ok(labelled.white > whole.white + 0.0005, `${labelled.white} ${whole.white}`);
  const onFloor = await picture('floor');
  assert.ok(onFloor.clear < 0.7, `${onFloor.clear}`);
  const alone = await picture();
  assert.ok(alone.clear > 0.5 && alone.clear < 0.99, `${alone.clear}`);
  // The view itself is as it was.
  assert.equal((await picture('floor', 'background')).clear, 0);
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
