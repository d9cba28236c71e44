// Makes the pictures of the page in docs/pictures, and those of robots in the page: `npm run pictures`, with the release build
// there.

import { execFileSync } from 'node:child_process';
import { join } from 'node:path';
import {
  connectClient,
  connectRobots,
  launchBrowser,
  openPage,
  program,
  root,
  startServer,
  waitForNumber,
} from './server.mjs';

const folder = join(root, 'docs/pictures');
const browser = await launchBrowser();

async function take(file, serve, options, prepare) {
  const server = await startServer(...serve);
  // As with a graphics card, however long it takes here.
  const { page } = await openPage(browser, server.url, { quality: '5', ...options });
  await prepare(page, server);
  // Messages would hide the view, and who uses no keyboard sees no focus.
  await page.evaluate(() => {
    document.getElementById('toasts').replaceChildren();
    document.getElementById('rate').hidden = true;
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

/** The camera flies to a robot that stands still. */
async function stop(page, key) {
  await page.keyboard.up(key);
  await page.keyboard.press('g');
  await page.waitForTimeout(6000);
}

const wide = { viewport: { width: 1280, height: 800 }, colorScheme: 'light' };
const phone = { viewport: { width: 390, height: 780 }, colorScheme: 'light', hasTouch: true, isMobile: true };

await take('door.png', [], { ...wide, door: true }, async (page) => {
  await page.click('[data-scenario=slalom]');
  await waitForNumber(page, '#time', (value) => value > 8);
});
await take('page.png', ['--map', 'arena'], wide, async (page, server) => {
  await drive(page, 'w', 'P3AT');
  await connectRobots(server.port, 4, 'YouBot');
  await connectClient(server.port, 'INIT {ClassName USARBot.Kenaf} {Name Kenaf} {Location 2.6,1.2,-0.1}');
  await page.click('[data-robot="0"]');
  await waitForNumber(page, '[data-value=x]', (value) => value > 1.2);
  await stop(page, 'w');
});
await take('plots.png', ['--map', 'rough'], wide, async (page) => {
  await drive(page, 'd');
  await page.selectOption('#camera', 'follow');
  await page.click('#toggle-plots');
  await waitForNumber(page, '#time', (value) => value > 8);
});
await take('code.png', ['--map', 'hall'], wide, async (page) => {
  await page.click('[data-tab=code]');
  await page.click('#run');
  await page.waitForSelector('[data-robot]');
  await page.keyboard.press('g');
  await page.waitForSelector('#output li');
  await page.waitForSelector('.numbers .lit:nth-child(6)');
});
await take('phone.png', ['--map', 'rough'], phone, async (page) => {
  await drive(page, 'd');
  await page.waitForTimeout(3000);
  await stop(page, 'd');
});
await browser.close();

/** Robots that the shipped maps offer first. */
const OFFERED = 'AirRobot ATRV Hummer KR60 Kenaf Kiva4Wheel Nao P3AT SoccerRobot YouBot YouBotArm'.split(' ');
for (const robot of OFFERED) {
  const out = join(root, `viewer/src/panel/robots/${robot}.png`);
  const options = ['--robot', robot, '--view', 'portrait', '--seconds', '0.3', '--size', '240x168', '--out', out];
  execFileSync(program, ['snapshot', '--map', 'smooth', ...options]);
}
