// The page in a real browser, as a person uses it. Each test leaves a picture in target/screenshots.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import {
  ABOVE,
  SLANTED,
  X,
  Y,
  near,
  pageTest,
  setQuality,
  spawnRobot,
  waitForPixels,
  waitForRobotInMiddle,
  waitForView,
} from './pagetest.mjs';
import { runnerImport } from 'vite';
import { connectRobots, number, pictures, program, root, startServer, until, waitForNumber } from './server.mjs';

const { AXIS_COLOURS, FORCE_COLOURS } = (await runnerImport(join(root, 'viewer/src/view/colours.ts'))).module;

pageTest('an empty world is shown at once', { serve: ['--map', 'arena'] }, async ({ page, seconds }) => {
  console.log(`# first picture after ${seconds.toFixed(2)} s`);
  assert.equal(await page.textContent('#map'), 'arena');
  await waitForNumber(page, '#time', (value) => value > 0.2);
  assert.match(await page.textContent('#robots'), /No robot yet/);
  // Not one colour: the floor, walls and the sky are there.
  const picture = await page.locator('#canvas').screenshot();
  assert.ok(picture.length > 15_000, `${picture.length} bytes`);
});

pageTest('a robot is spawned and driven by keys', { serve: ['--map', 'arena'] }, async ({ page }) => {
  await spawnRobot(page);
  await waitForNumber(page, Y, (value) => Math.abs(value) < 0.01);
  await page.keyboard.down('d');
  await waitForNumber(page, Y, (value) => value > 0.3);
  assert.ok((await number(page, '[data-value=target0]')) > 1);
  await page.keyboard.up('d');
  await waitForNumber(page, '[data-value=target0]', (value) => value === 0);
  await page.keyboard.down('q');
  await waitForNumber(page, '[data-value=yaw]', (value) => value < -10);
  await page.keyboard.up('q');
  await page.keyboard.down('w');
  await waitForNumber(page, X, (value) => value > 0.1);
  await page.keyboard.up('w');
  await page.click('[data-tab=drive]');
  await page.click('#remove');
  await page.waitForSelector('[data-robot]', { state: 'detached' });
});

pageTest('a skid robot is driven by keys too', { serve: ['--map', 'rough'] }, async ({ page }) => {
  await spawnRobot(page, { robotClass: 'P3AT' });
  await page.keyboard.down('ArrowUp');
  await waitForNumber(page, X, (value) => value > 0.3);
  await page.keyboard.down('ArrowRight');
  await waitForNumber(page, '[data-value=yaw]', (value) => value > 10);
});

pageTest('sliders move the joints of an arm', { serve: ['--map', 'rough'] }, async ({ page }) => {
  await spawnRobot(page, { robotClass: 'YouBotArm' });
  await page.locator('#joint-ArmJoint1').evaluate((slider) => {
    slider.value = '1';
    slider.dispatchEvent(new Event('input'));
  });
  await page.click('[data-tab=wire]');
  await page.fill('[name=filter]', 'ASTA');
  const arrived = () => {
    const lines = [...document.querySelectorAll('#lines li')];
    return lines.some(({ textContent }) => /ASTA.*\{Link 1\} \{Value (0\.99|1\.00)/.test(textContent));
  };
  await page.waitForFunction(arrived);
});

pageTest('a robot is spawned where one clicks', { serve: ['--map', 'arena'] }, async ({ page }) => {
  await page.selectOption('select[name=start]', '');
  await page.click('#spawn');
  await page.waitForSelector('#view.placing');
  // The whole map is in sight, and the camera looks at its middle.
  await page.click('#canvas');
  await page.waitForSelector('[data-robot]', { state: 'attached' });
  for (const place of [X, Y]) await waitForNumber(page, place, (value) => Math.abs(value) < 4);
});

pageTest('time is paused, stepped and hurried', { serve: ['--map', 'rough'] }, async ({ page }) => {
  await waitForNumber(page, '#time', (value) => value > 0.2);
  await page.click('#pause');
  await page.waitForSelector('#pause[aria-pressed=true]');
  // A page that opens now has no earlier frame.
  await page.reload();
  await page.waitForSelector('#pause[aria-pressed=true]');
  const before = await waitForNumber(page, '#time', (value) => value > 0);
  await page.click('#step');
  const after = await waitForNumber(page, '#time', (value) => value > before);
  assert.equal((after - before).toFixed(4), '0.0100');
  await page.selectOption('#speed', '4');
  await page.click('#pause');
  await waitForNumber(page, '#factor', (value) => value > 2);
});

pageTest('a reset puts the robots back', { serve: ['--map', 'rough'] }, async ({ page }) => {
  await spawnRobot(page, { start: 'RobotStart1' });
  await page.keyboard.down('w');
  await waitForNumber(page, X, (value) => value > 2.3);
  await page.keyboard.up('w');
  await page.click('#reset');
  await page.waitForSelector('#toasts :text("You reset the world")');
  await waitForNumber(page, X, (value) => Math.abs(value - 2) < 0.01);
  await page.keyboard.down('w');
  await waitForNumber(page, X, (value) => value > 2.2);
});

pageTest('a log is recorded and reads', { serve: ['--map', 'rough'] }, async ({ page, server }) => {
  await page.click('#record');
  await page.waitForSelector('#record[aria-pressed=true]');
  await page.waitForSelector('#toasts :text("usarsim-rough.mcap")');
  await spawnRobot(page);
  await waitForNumber(page, '#time', (value) => value > 1);
  await page.click('#record');
  await page.waitForSelector('#record[aria-pressed=false]');
  assert.deepEqual(readdirSync(server.folder), ['usarsim-rough.mcap']);
  const said = execFileSync(program, ['log', 'info', join(server.folder, 'usarsim-rough.mcap')]).toString();
  assert.match(said, /KUKA_YouBot/);
});

pageTest('plots are drawn', { serve: ['--map', 'rough'] }, async ({ page }) => {
  await spawnRobot(page);
  await page.keyboard.down('d');
  await page.click('#toggle-plots');
  await page.waitForFunction(() => {
    const inked = (canvas) => {
      const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      return data.filter((_, index) => index % 4 === 3 && data[index] > 0).length;
    };
    const canvases = [...document.querySelectorAll('.chart canvas')];
    return canvases.length === 3 && canvases.every((canvas) => inked(canvas) > 500);
  });
  await waitForNumber(page, '#time', (value) => value > 6);
});

pageTest(
  'a value is plotted against another, and what a laser sees',
  { serve: ['--map', 'hall'] },
  async ({ page }) => {
    await spawnRobot(page, { robotClass: 'P3AT' });
    await page.click('#toggle-plots');
    await page.waitForSelector('.plane:not([hidden])');
    await page.selectOption('[aria-label="Value that goes right"]', 'robot 0/x');
    await page.selectOption('[aria-label="Value that goes up"]', 'robot 0/y');
    await page.click('#plot-against');
    await page.click('#plot-laser');
    await page.keyboard.down('w');
    await page.keyboard.down('q');
    const inked = (label) =>
      page.waitForFunction((label) => {
        const canvas = document.querySelector(`canvas[aria-label^="${label}"]`);
        if (!canvas?.width) return false;
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        let blue = 0;
        for (let at = 0; at < data.length; at += 4) if (data[at + 2] > data[at] + 80 && data[at + 3] > 200) blue++;
        return blue > 150;
      }, label);
    await inked('Robot1 y against Robot1 x');
    await inked('Robot1 lms200');
    await page.click('[aria-label="Close the plot of Robot1 lms200"]');
    await page.waitForSelector('canvas[aria-label^="Robot1 lms200"]', { state: 'detached' });
  },
);

pageTest('lines of the wire are shown and filtered', { serve: ['--map', 'rough'] }, async ({ page }) => {
  await page.click('[data-tab=wire]');
  await spawnRobot(page);
  await page.click('[data-tab=wire]');
  await page.waitForSelector('#lines .out:has-text("GroundTruth")');
  await page.fill('[name=filter]', 'STA {');
  await page.waitForFunction(() => {
    const lines = [...document.querySelectorAll('#lines li')].map((line) => line.textContent);
    return lines.length > 2 && lines.every((line) => line.includes('STA {'));
  });
  await page.fill('[name=filter]', '');
  await page.selectOption('[name=direction]', 'in');
  await page.keyboard.press('Escape');
  await page.click('#view', { position: { x: 20, y: 200 } });
  await page.keyboard.press('w');
  await page.waitForSelector('#lines .in:has-text("DRIVE")');
});

pageTest(
  'a finger drives on a phone',
  { serve: ['--map', 'rough'], page: { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true } },
  async ({ page }) => {
    await page.tap('[data-sheet=drive]');
    await page.tap('#spawn');
    await page.waitForSelector('[data-robot]', { state: 'attached' });
    await page.waitForSelector('#sticks:not([hidden])');
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'nothing is cut off');
    const { x, y, width, height } = await page.locator('[data-stick=move]').boundingBox();
    const session = await page.context().newCDPSession(page);
    const touch = (type, points) => session.send('Input.dispatchTouchEvent', { type, touchPoints: points });
    await touch('touchStart', [{ x: x + width / 2, y: y + height / 2 }]);
    await touch('touchMove', [{ x: x + width / 2, y: y + 10 }]);
    // A tap would end the touch.
    await page.evaluate(() => document.querySelector('[data-sheet=world]').click());
    await waitForNumber(page, X, (value) => value > 0.1);
    await touch('touchEnd', []);
    await waitForNumber(page, '[data-value=target0]', (value) => value === 0);
  },
);

// Small, as the picture is drawn at the best quality. A narrower page has no button for pictures.
const small = { viewport: { width: 1040, height: 600 } };
pageTest(
  'views, layers, colours and a picture',
  { serve: ['--map', 'arena'], page: small },
  async ({ page, server }) => {
    await connectRobots(server.port, 3);
    await page.waitForSelector('[data-robot="2"]');
    await setQuality(page, 1);
    const theme = () => page.getAttribute('html', 'data-theme');
    const before = await theme();
    await page.click('#theme');
    assert.deepEqual([before, await theme()].sort(), ['dark', 'light']);
    // Seen from above, the vertical axis is a point.
    await page.selectOption('#camera', 'top');
    await waitForView(page, ABOVE);
    await page.selectOption('#camera', 'orbit');
    await waitForView(page, SLANTED);
    await page.selectOption('#camera', 'follow');
    await waitForRobotInMiddle(page);
    await page.click('#layers summary');
    for (const layer of ['forces', 'frames']) await page.check(`[name=${layer}]`);
    await page.click('#layers summary');
    await waitForPixels(page, 40, ...near(FORCE_COLOURS[0], 50));
    for (const colour of AXIS_COLOURS) await waitForPixels(page, 5, ...near(colour, 40));
    // Without a graphics card the best quality takes a while.
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('#screenshot')]);
    const path = join(pictures, 'picture-by-the-page.png');
    await download.saveAs(path);
    assert.ok(statSync(path).size > 20_000);
  },
);

pageTest(
  'many robots are shown',
  { serve: ['--map', 'arena', '--drive-model', 'analytic'] },
  async ({ page, server }) => {
    await connectRobots(server.port, 20);
    await page.waitForSelector('[data-robot="19"]');
    await page.selectOption('#camera', 'top');
    await waitForView(page, ABOVE);
    await page.keyboard.press('Home');
    await page.waitForFunction(() => document.querySelectorAll('.view-label.robot').length === 20);
    // They drive, so that their names move, and a frame is drawn for each of the server's.
    const places = () =>
      page.evaluate(() => [...document.querySelectorAll('.view-label.robot')].map(({ style }) => style.transform));
    const before = await places();
    await until(async () => (await places()).every((place, index) => place !== before[index]), 'all names have moved');
    await page.waitForFunction(() => / · [1-9]\d* fps$/.test(document.querySelector('#rate').textContent));
    console.log(`# 20 robots: ${await page.textContent('#rate')}`);
  },
);

pageTest('the page survives a reload and a server that is gone', { mayFail: true }, async ({ page, server }) => {
  await page.reload();
  await page.waitForFunction(() => document.documentElement.dataset.state === 'live');
  await server.stop('SIGKILL');
  await page.waitForSelector('#banner:has-text("lost")');
  const again = await startServer('--map', 'arena', '--port', String(server.port), '--http', String(server.http));
  try {
    await page.waitForFunction(() => document.documentElement.dataset.state === 'live');
    await page.waitForSelector('#banner', { state: 'hidden' });
    await page.waitForSelector('#toasts :text("The map is now arena")');
    assert.equal(await page.textContent('#map'), 'arena');
    await spawnRobot(page);
    await page.screenshot({ path: join(pictures, 'a-server-that-came-back.png') });
  } finally {
    await again.stop();
  }
});
