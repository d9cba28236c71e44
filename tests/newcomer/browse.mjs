// What a new user does in the browser: `browse.mjs by-hand|own FOLDER-OF-THE-SERVER PICTURES`, with a server on port 8080.

import assert from 'node:assert/strict';
import { readdirSync } from 'node:fs';
import { join } from 'node:path';
import { launchBrowser, number, openPage, waitForNumber } from '../../viewer/tests/server.mjs';

const [task, folder, pictures] = process.argv.slice(2);
const [X, TIME] = ['[data-value=x]', '#time'];
const browser = await launchBrowser();
const { page, errors } = await openPage(browser, 'http://127.0.0.1:8080/');
const picture = (name) => page.screenshot({ path: join(pictures, `${name}.png`) });

/** Holds a key until the chosen robot has moved forward. */
async function driveForward(distance) {
  const start = await waitForNumber(page, X, Number.isFinite);
  await page.keyboard.down('w');
  await waitForNumber(page, X, (x) => x > start + distance);
  await page.keyboard.up('w');
}

async function byHand() {
  await picture('first');
  await page.click('[data-spawn=P3AT]');
  await driveForward(0.3);
  await page.click(X);
  await page.waitForSelector('#plots:not([hidden]) .u-legend :text("x")');
  await page.click('#record');
  await page.waitForSelector('#record[aria-pressed=true]');
  await driveForward(0.3);
  await page.click('#record');
  await page.waitForSelector('#record[aria-pressed=false]');
  await picture('driven');
  const driven = await number(page, X);
  const [log] = readdirSync(folder).filter((name) => name.endsWith('.mcap'));
  assert.ok(log, `no log in ${folder}`);
  await page.setInputFiles('#log-file', join(folder, log));
  await page.waitForSelector('#mode[data-mode=log]');
  const began = await waitForNumber(page, X, Number.isFinite);
  assert.ok(began < driven - 0.2, `the log begins at ${began} m, before ${driven} m`);
  await waitForNumber(page, X, (x) => x > began + 0.2);
  await picture('played-back');
  await page.click('#live');
  await page.waitForSelector('#mode:not([data-mode=log])');
}

async function own() {
  await page.click('[data-tab=drive]');
  await page.selectOption('select[name=class]', 'Cart');
  await page.click('#spawn');
  await page.waitForSelector('[data-robot]');
  await driveForward(0.3);
  const now = await number(page, TIME);
  await waitForNumber(page, TIME, (time) => time > now + 1);
  assert.equal(await page.textContent('#map'), 'lab');
  await picture('own');
}

await { 'by-hand': byHand, own }[task]();
assert.deepEqual(errors, []);
await browser.close();
