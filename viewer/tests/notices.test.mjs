// What the page says to people.

import assert from 'node:assert/strict';
import { pageTest, spawnRobot } from './pagetest.mjs';
import { connectClient, number, waitForNumber } from './server.mjs';

pageTest('a world that is too slow has a sign and no message', { serve: ['--rtf', '10000'] }, async (it) => {
  const { page, server } = it;
  await spawnRobot(page, { robotClass: 'P3AT' });
  await page.waitForSelector('#slow:not([hidden])');
  assert.match(await page.getAttribute('#slow', 'title'), /instead of 10000\./);
  await page.click('#slow');
  await page.waitForSelector('dialog:has-text("Remove robots")');
  await page.keyboard.press('Escape');
  // The server's own log has it, every five seconds of real time; the page would be told in the same step.
  await server.logged('behind real time');
  const now = await number(page, '#time');
  await waitForNumber(page, '#time', (time) => time > now);
  assert.equal((await page.locator('#toasts').textContent()).includes('behind'), false);
  await page.selectOption('#speed', '1');
  await page.waitForSelector('#slow', { state: 'hidden' });
});

pageTest('a name that the wire changes is shown before', { serve: ['--map', 'rough'] }, async ({ page }) => {
  await page.fill('[name=name]', 'Bad Name {x}');
  await page.waitForSelector(
    '#name-hint:has-text("It will be named Bad_Name_x_: a name has no spaces and no braces.")',
  );
  await page.fill('[name=name]', 'Good');
  await page.waitForSelector('#name-hint', { state: 'hidden' });
});

pageTest('problems of clients are told in plain words', { serve: ['--map', 'rough'] }, async ({ page, server }) => {
  // A message stays for six seconds, in which a busy machine may draw nothing.
  await page.evaluate(() => {
    window.told = [];
    const tell = (records) =>
      records.forEach(({ addedNodes }) => addedNodes.forEach((it) => told.push(it.textContent)));
    new MutationObserver(tell).observe(document.querySelector('#toasts'), { childList: true });
  });
  const isTold = (text) => page.waitForFunction((text) => told.some((it) => it.startsWith(text)), text);
  const init = (x) => `INIT {ClassName USARBot.P3AT} {Name Twin} {Location ${x},0,-0.1}`;
  await connectClient(server.port, init(0));
  await page.waitForSelector('[data-robot]');
  const client = await connectClient(server.port, init(3));
  await isTold('Another robot is named Twin, too');
  await page.waitForSelector('[data-robot="1"]');
  client.send('DRIVE {Left wrong}');
  await isTold('Twin: ');
  const toasts = (await page.evaluate(() => told)).join();
  assert.ok(!/connection \d/.test(toasts) && !/DRIVE \{/.test(toasts), toasts);
  // The raw lines stay.
  await page.click('[data-tab=wire]');
  await page.waitForSelector('#lines .said:has-text("line 3: ")');
});
