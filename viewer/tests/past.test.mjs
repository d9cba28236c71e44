// The last minute, and logs: they are looked at, and nobody is driven meanwhile.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { X, pageTest, spawnRobot } from './pagetest.mjs';
import { connectClient, number, openPage, startServer, until, waitForNumber } from './server.mjs';

const rough = { serve: ['--map', 'rough'] };
const BAND = '#past:not([hidden])';

/** Moves the slider of the time line to a part of its range. */
const look = (page, part) =>
  page.locator('#timeline').evaluate((timeline, part) => {
    const [min, max] = [Number(timeline.min), Number(timeline.max)];
    timeline.value = String(min + part * (max - min));
    timeline.dispatchEvent(new Event('input'));
  }, part);

/** Drives until x is so large. */
async function drive(page, until) {
  await page.keyboard.down('w');
  await waitForNumber(page, X, (value) => value > until);
  await page.keyboard.up('w');
}

/** Waits until so many seconds of the past can be shown: a page that opens late knows less of it. */
const waitForPast = (page, seconds) =>
  page.waitForFunction((seconds) => {
    const { min, max } = document.querySelector('#timeline');
    return max - min > seconds;
  }, seconds);

/** The times in the plots' table. */
async function plotted(page) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#save-csv')]);
  const [, ...lines] = readFileSync(await download.path(), 'utf8').split('\n');
  return lines.map((line) => Number(line.split(',')[0]));
}

/** Where the line of the shown moment is in the first chart, as a part of its width; null without one. */
const cursor = (page) =>
  page.evaluate(() => {
    const line = document.querySelector('.chart .moment');
    return line && !line.hidden ? line.offsetLeft / line.parentElement.clientWidth : null;
  });

pageTest('keys drive nobody while the past is shown, and space plays it', rough, async ({ page, server }) => {
  const sent = [];
  page.on('websocket', (socket) =>
    socket.on('framesent', ({ payload }) => {
      if (/^DRIVE.*[1-9]|^SET|pause/.test(String(payload))) sent.push(String(payload).trim());
    }),
  );
  const { page: other } = await openPage(page.context().browser(), server.url);
  await spawnRobot(page, { robotClass: 'YouBotArm' });
  await drive(page, 0.5);
  // Enough of it is left to play, also where the world is slower than real time.
  await waitForPast(page, 4);
  await look(page, 0.3);
  await page.waitForSelector(`${BAND}:has-text("You are looking at the past. Keys do not drive.")`);
  const then = await number(page, '#time');
  const before = sent.length;
  assert.ok(before > 0);
  const keys = ['w', 'd', 'ArrowUp'];
  for (const key of keys) await page.keyboard.down(key);
  assert.ok(await page.isDisabled('#joint-ArmJoint1'));
  await page.keyboard.press(' ');
  await waitForNumber(page, '#time', (time) => time > then + 0.4);
  for (const key of keys) await page.keyboard.up(key);
  await page.waitForSelector('#pause:text-is("Pause")');
  await page.keyboard.press(' ');
  await page.waitForSelector('#pause:text-is("Play")');
  // Two steps are two moments before the end: how far frames lie apart is up to the machine.
  for (let step = 0; step < 2; step++) {
    const stopped = await number(page, '#time');
    await page.keyboard.press('.');
    await waitForNumber(page, '#time', (time) => time > stopped);
  }
  assert.ok((await number(page, '#time')) < (await page.locator('#timeline').evaluate(({ max }) => Number(max))));
  // The world went on meanwhile, and nobody was told to stop it.
  const now = await number(other, '#time');
  await waitForNumber(other, '#time', (time) => time > now + 0.2);
  assert.equal(await other.getAttribute('#pause', 'aria-pressed'), 'false');
  assert.deepEqual(sent.slice(before), []);
  await page.click('#live');
  await page.waitForSelector(BAND, { state: 'detached' });
  const x = await waitForNumber(page, X, (value) => value > 0.5);
  await drive(page, x + 0.1);
  await other.context().close();
});

pageTest('the past is played faster, and stops where it ends', rough, async ({ page }) => {
  await page.selectOption('#speed', '4');
  await waitForNumber(page, '#time', (time) => time > 16);
  await page.click('#pause');
  await page.waitForSelector('#pause[aria-pressed=true]');
  await look(page, 0);
  await page.waitForSelector(BAND);
  await page.selectOption('#speed', '4');
  const [begin, end] = await page.locator('#timeline').evaluate(({ min, max }) => [Number(min), Number(max)]);
  await page.click('#pause');
  const started = Date.now();
  await waitForNumber(page, '#time', (time) => time > end - 0.05);
  assert.ok(Date.now() - started < (1000 * (end - begin)) / 2, `${Date.now() - started} ms`);
  await page.waitForSelector('#pause:text-is("Play")');
  await page.waitForSelector(BAND);
});

pageTest('plots keep their curves while the past is shown, with a cursor', rough, async ({ page }) => {
  await spawnRobot(page);
  await drive(page, 0.3);
  await waitForPast(page, 4);
  await page.click('[data-value=x]');
  await page.waitForSelector('.chart');
  assert.equal(await cursor(page), null);
  const now = await number(page, '#time');
  await look(page, 0.25);
  const then = await waitForNumber(page, '#time', (time) => time < now - 2);
  await page.waitForFunction(() => !document.querySelector('.chart .moment').hidden);
  assert.ok(Math.max(...(await plotted(page))) > then + 1.5);
  // The legend has the numbers of that moment.
  await waitForNumber(page, '.u-legend .u-value', (time) => Math.abs(time - then) < 0.05);
  const early = await cursor(page);
  await look(page, 0.75);
  await page.waitForFunction((early) => {
    const line = document.querySelector('.chart .moment');
    return line.offsetLeft / line.parentElement.clientWidth > early + 0.2;
  }, early);
  await page.click('#live');
  await page.waitForFunction(() => document.querySelector('.chart .moment').hidden);
});

pageTest('the time line has times and marks', rough, async ({ page, server }) => {
  const mark = (title) => page.waitForSelector(`.mark[title$=${JSON.stringify(title)}]`, { state: 'attached' });
  await waitForNumber(page, '#time', (time) => time > 0.5);
  await spawnRobot(page);
  await mark('Robot1 came');
  await page.click('#record');
  await mark('Recording started');
  await page.click('#record');
  await mark('Recording stopped');
  const other = await connectClient(server.port, 'INIT {ClassName USARBot.P3AT} {Name Other} {Location 3,0,-0.1}');
  await mark('Other came');
  other.end();
  await mark('Other left');
  assert.match(await page.textContent('#first-time'), /^\d+\.\d s$/);
  assert.match(await page.textContent('#last-time'), /^\d+\.\d s$/);
  await page.locator('.mark >> nth=0').dispatchEvent('click');
  await page.waitForSelector(BAND);
  await page.click('#reset');
  await mark('The world was reset');
  // The past of the world before is gone.
  await page.waitForSelector(BAND, { state: 'detached' });
  assert.equal(await page.locator('.mark').count(), 1);
});

pageTest('plots show all of a log, with a cursor, and its robots are marked', rough, async ({ page }) => {
  const recording = await startServer('--map', 'rough', '--log', 'run.mcap');
  const { page: watching } = await openPage(page.context().browser(), recording.url);
  await waitForNumber(watching, '#time', (time) => time > 1);
  const init = 'INIT {ClassName USARBot.P3AT} {Name Recorded} {Start PlayerStart_0}';
  const client = await connectClient(recording.port, init, 'DRIVE {Left 3} {Right 3}');
  // The page's clock lags behind the frames that it has.
  const came = await client.reaches(0);
  await client.reaches(came + 3);
  await watching.context().close();
  await recording.stop();
  client.end();
  await page.setInputFiles('#log-file', join(recording.folder, 'run.mcap'));
  await page.waitForSelector(`${BAND}:has-text("You are looking at the log run.mcap. Keys do not drive.")`);
  await page.waitForFunction((end) => Number(document.querySelector('#timeline').max) > end, came + 2.5);
  await page.click('#pause');
  const end = await page.locator('#timeline').evaluate((timeline) => Number(timeline.max));
  const shown = (came + 1.5) / end;
  await look(page, shown);
  await page.waitForSelector('.mark[title$="Recorded came"]', { state: 'attached' });
  await page.click('[data-value=x]');
  await page.waitForSelector('.chart');
  const times = await plotted(page);
  assert.ok(Math.min(...times) < came + 0.5 && Math.max(...times) > came + 2.5, `${times[0]} ${times.at(-1)} ${came}`);
  await page.waitForFunction(() => !document.querySelector('.chart .moment').hidden);
  const middle = await cursor(page);
  assert.ok(Math.abs(middle - shown) < 0.15, `${middle} ${shown}`);
  // Playing on takes nothing away.
  await look(page, 0.1);
  await page.keyboard.press(' ');
  await page.waitForSelector('#pause:text-is("Pause")');
  assert.ok((await plotted(page)).length >= times.length);
});

pageTest('a key goes back by a frame, and another one returns to the present', rough, async ({ page }) => {
  await waitForPast(page, 1);
  await page.keyboard.press(',');
  await page.waitForSelector(BAND);
  // The numbers follow the shown moment once a second or more often.
  let [first, since] = [0, 0];
  await until(async () => {
    const shown = await number(page, '#time');
    if (shown !== first) [first, since] = [shown, Date.now()];
    return Date.now() - since > 3000;
  });
  await page.keyboard.press(',');
  await waitForNumber(page, '#time', (time) => time < first);
  // How far frames lie apart is up to the machine.
  await page.keyboard.press('.');
  await waitForNumber(page, '#time', (time) => time === first);
  await page.keyboard.press('End');
  await page.waitForSelector('#past', { state: 'hidden' });
});

pageTest(
  'a page that opens late has the run from its beginning, with who has left',
  rough,
  async ({ page, server }) => {
    const early = 'INIT {ClassName USARBot.P3AT} {Name Early} {Start RobotStart1}';
    const client = await connectClient(server.port, early, 'DRIVE {Left 2} {Right 2}');
    const came = await client.reaches(0);
    const left = await client.reaches(came + 2);
    client.end();
    await page.waitForSelector('.mark[title$="Early left"]', { state: 'attached' });
    const { page: late, errors } = await openPage(page.context().browser(), server.url, {
      reducedMotion: 'reduce',
    });
    for (const what of ['came', 'left']) {
      await late.waitForSelector(`.mark[title$="Early ${what}"]`, { state: 'attached' });
    }
    const { min, max } = await late.locator('#timeline').evaluate(({ min, max }) => ({ min: +min, max: +max }));
    assert.ok(min < 1.5, `the past begins at ${min} s`);
    await look(late, ((came + left) / 2 - min) / (max - min));
    await late.waitForSelector(BAND);
    await late.waitForFunction(() => {
      const label = [...document.querySelectorAll('.view-label.robot')].find((it) => it.textContent === 'Early');
      return label && Number(label.style.opacity) > 0;
    });
    // It began anew: nothing of the run before is left.
    await page.click('#reset');
    await late.waitForFunction((left) => Number(document.querySelector('#timeline').max) < left, left);
    assert.equal(await late.locator('.mark[title$="Early left"]').count(), 0);
    assert.deepEqual(errors, []);
    await late.context().close();
  },
);
