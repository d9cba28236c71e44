// Words over the picture, and what is drawn over robots.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { runnerImport } from 'vite';
import { ABOVE, near, pageTest, setQuality, spawnRobot, waitForPixels, waitForView } from './pagetest.mjs';
import { connectClient, root } from './server.mjs';

const rough = { serve: ['--map', 'rough'] };

/** Contrast of the text of a label with its plate, on white and on black. Labels come and go, so one is found and read at once. */
const contrasts = async (page, kind) => {
  const read = (selector) => {
    const label = document.querySelector(selector);
    if (!label) return null;
    const { color, backgroundColor } = getComputedStyle(label);
    const [text, plate] = [color, backgroundColor].map((colour) => colour.match(/[\d.]+/g).map(Number));
    const light = (rgb) =>
      rgb
        .map((part) => part / 255)
        .map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4))
        .reduce((sum, part, index) => sum + part * [0.2126, 0.7152, 0.0722][index], 0);
    return [255, 0].map((behind) => {
      const alpha = plate[3] ?? 1;
      const seen = plate.slice(0, 3).map((part) => alpha * part + (1 - alpha) * behind);
      const [one, other] = [light(text.slice(0, 3)), light(seen)].sort((a, b) => b - a);
      return (one + 0.05) / (other + 0.05);
    });
  };
  return (await page.waitForFunction(read, `.view-label.${kind}`)).jsonValue();
};

for (const colorScheme of ['light', 'dark']) {
  pageTest(
    `labels are read on their plates in ${colorScheme} colours`,
    { ...rough, page: { colorScheme } },
    async ({ page, server }) => {
      await page.waitForSelector('.view-label.start', { state: 'attached' });
      await connectClient(server.port, 'INIT {ClassName USARBot.P3AT} {Name Robot1} {Location 3,0,-0.1}');
      await page.waitForSelector('.view-label.robot', { state: 'attached' });
      for (const kind of ['metres', 'start', 'robot']) {
        for (const contrast of await contrasts(page, kind)) assert.ok(contrast >= 4.5, `${kind}: ${contrast}`);
      }
    },
  );
}

pageTest('a start has no label while a robot stands on it', rough, async ({ page }) => {
  const start = '.view-label.start:text-is("PlayerStart_0")';
  await page.waitForSelector(start, { state: 'attached' });
  await spawnRobot(page, { robotClass: 'P3AT' });
  await page.waitForSelector(start, { state: 'detached' });
  await page.click('#remove');
  await page.waitForSelector(start, { state: 'attached' });
});

pageTest('labels behind a robot are hidden', rough, async ({ page, server }) => {
  await page.selectOption('#camera', 'top');
  await page.waitForFunction(() =>
    ['x', 'y'].every((axis) => {
      const labels = [...document.querySelectorAll('.view-label.metres')];
      const own = labels.filter(({ textContent }) => textContent.startsWith(axis));
      return own.filter(({ style }) => Number(style.opacity) > 0.5).length > 1;
    }),
  );
  await waitForView(page, ABOVE);
  // Numbers of the y axis stand beside each other, and tell where the line is on which those of the x axis stand.
  const { text, place } = await page.evaluate(() => {
    const labels = [...document.querySelectorAll('.view-label.metres')].filter(
      ({ style }) => Number(style.opacity) > 0.5,
    );
    const placed = labels.map((label) => {
      const { left, top, width, height } = label.getBoundingClientRect();
      const [axis, at] = label.textContent.split(' ');
      return { text: label.textContent, axis, at: Number(at), x: left + width / 2, y: top + height / 2 };
    });
    const [one, other] = placed.filter(({ axis }) => axis === 'y');
    const own = placed.find(({ axis }) => axis === 'x');
    const [dx, dy] = [other.x - one.x, other.y - one.y];
    const part = ((own.x - one.x) * dx + (own.y - one.y) * dy) / (dx * dx + dy * dy);
    return { text: own.text, place: [own.at, one.at + part * (other.at - one.at)] };
  });
  await connectClient(server.port, `INIT {ClassName USARBot.P3AT} {Name Robot1} {Location ${place},-0.2}`);
  await page.waitForFunction((text) => {
    const label = [...document.querySelectorAll('.view-label.metres')].find(({ textContent }) => textContent === text);
    return label && Number(label.style.opacity) === 0;
  }, text);
});

pageTest('forces have a colour of their own that stays at the lowest quality', rough, async ({ page }) => {
  const { module: colours } = await runnerImport(join(root, 'viewer/src/view/colours.ts'));
  const parts = (colour) => [1, 3, 5].map((at) => Number.parseInt(colour.slice(at, at + 2), 16));
  for (const [r, g, b] of colours.FORCE_COLOURS.map(parts)) {
    for (const colour of [...colours.COLOURS, ...colours.AXIS_COLOURS]) {
      const [red, green, blue] = parts(colour);
      assert.ok(Math.hypot(red - r, green - g, blue - b) > 110, colour);
    }
  }
  await setQuality(page, 1);
  await spawnRobot(page, { robotClass: 'P3AT' });
  await page.click('#layers summary');
  await page.check('[name=forces]');
  await page.keyboard.press('Home');
  await waitForPixels(page, 40, ...near(colours.FORCE_COLOURS[0], 50));
});
