// A server that asks for a token.

import assert from 'node:assert/strict';
import { mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pageTest } from './pagetest.mjs';

const [WATCHES, DRIVES, RULES] = ['watches', 'drives', 'rules'].map((name) => `${name}-0123456789abcdef`);
const file = join(mkdtempSync(join(tmpdir(), 'tokens-')), 'tokens.toml');
writeFileSync(
  file,
  `[[token]]
token = "${WATCHES}"
roles = ["viewer"]

[[token]]
token = "${DRIVES}"
roles = ["viewer", "driver"]

[[token]]
token = "${RULES}"
roles = ["viewer", "referee"]
`,
);
const serve = ['--token-file', file];
const isLive = (page) => page.waitForFunction(() => document.documentElement.dataset.state === 'live');
const toast = (page, text) => page.getByText(text).first().waitFor();

// The browser itself writes to the console that a request was refused.
pageTest(
  'the page asks for a token until the server takes one',
  { serve, path: `#token=${WATCHES}`, mayFail: true },
  async ({ page }) => {
    assert.equal(await page.evaluate(() => location.hash), '');
    await page.reload();
    await isLive(page);
    await page.evaluate(() => sessionStorage.clear());
    await page.reload();
    await page.fill('#token', 'wrong-0123456789abcdef');
    await page.click('dialog button.main');
    await toast(page, 'does not accept this token');
    await page.fill('#token', WATCHES);
    await page.click('dialog button.main');
    await isLive(page);
  },
);

pageTest('a viewer neither drives nor pauses', { serve, path: `#token=${WATCHES}` }, async ({ page }) => {
  await page.click('[data-spawn=P3AT]');
  await toast(page, 'has not the role driver or referee');
  await page.waitForSelector(
    '#pause[aria-disabled=true][title="only a token with the role referee controls this world"]',
  );
});

pageTest('a driver drives', { serve, path: `#token=${DRIVES}` }, async ({ page }) => {
  await page.click('[data-spawn=P3AT]');
  await page.waitForFunction(() => document.querySelector('#welcome').hidden);
});

pageTest('a referee pauses', { serve, path: `#board&token=${RULES}` }, async ({ page }) => {
  assert.equal(await page.evaluate(() => location.hash), '#board');
  await page.click('#pause');
  await page.waitForFunction(() => document.querySelector('#mode').dataset.mode === 'paused');
});
