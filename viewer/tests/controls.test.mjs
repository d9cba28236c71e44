// Keys, focus, and what the form to spawn a robot offers.

import assert from 'node:assert/strict';
import { X, Y, pageTest, spawnRobot } from './pagetest.mjs';
import { connectClient, number, until, waitForNumber } from './server.mjs';

const rough = { serve: ['--map', 'rough'] };
const TARGET = '[data-value=target0]';
const STARTS = 'select[name=start]';

const paused = (page, pressed) => page.waitForSelector(`#pause[aria-pressed=${pressed}]`);
const robots = (page) => page.locator('[data-robot]').count();
const options = (page) => page.locator(`${STARTS} option`).allTextContents();
const offers = (page, selector, value) =>
  page.waitForFunction(([selector, value]) => document.querySelector(selector).value === value, [selector, value]);

/** Every DRIVE line that the page sends from now on. */
function drives(page) {
  const lines = [];
  page.on('websocket', (socket) =>
    socket.on('framesent', ({ payload }) => {
      if (String(payload).startsWith('DRIVE')) lines.push(String(payload).trim());
    }),
  );
  return lines;
}

/** Presses a key until the chosen robot's first wheel is to turn. */
async function drive(page, key) {
  await page.keyboard.down(key);
  await waitForNumber(page, TARGET, (value) => value !== 0);
  await page.keyboard.up(key);
  await waitForNumber(page, TARGET, (value) => value === 0);
}

pageTest('space after a spawn pauses and spawns no second robot', rough, async ({ page }) => {
  await spawnRobot(page);
  await page.keyboard.press(' ');
  await paused(page, true);
  await page.keyboard.press(' ');
  await paused(page, false);
  const now = await number(page, '#time');
  await waitForNumber(page, '#time', (value) => value > now + 0.5);
  assert.equal(await robots(page), 1);
});

pageTest('space presses no button while a robot is driven', rough, async ({ page }) => {
  const theme = () => page.getAttribute('html', 'data-theme');
  const before = await theme();
  await page.focus('#theme');
  await page.keyboard.press(' ');
  assert.notEqual(await theme(), before);
  await page.keyboard.press(' ');
  await spawnRobot(page);
  let pressed = false;
  for (const button of ['#spawn', '#remove', '#theme', '#pause', '#layers summary', '[data-tab=wire]']) {
    await page.focus(button);
    await page.keyboard.press(' ');
    pressed = !pressed;
    await paused(page, pressed);
  }
  assert.equal(await robots(page), 1);
  assert.equal(await theme(), before);
  assert.ok(await page.isHidden('#layers .menu'));
  assert.ok(await page.isVisible('#drive'));
  // By the other key they are pressed.
  await page.focus('#theme');
  await page.keyboard.press('Enter');
  assert.notEqual(await theme(), before);
});

pageTest('arrows drive after a choice was made', rough, async ({ page }) => {
  await spawnRobot(page);
  for (const [control, value] of [
    ['#camera', 'follow'],
    ['#camera', 'orbit'],
    ['#speed', '2'],
    ['select[name=class]', 'P3AT'],
    [STARTS, 'RobotStart2'],
    ['select[name=own]', 'Robot1'],
  ]) {
    await page.click(control);
    await page.selectOption(control, value);
    await drive(page, 'ArrowUp');
  }
  await page.click('#layers summary');
  await page.click('input[name=frames]');
  await page.keyboard.press(' ');
  await paused(page, true);
  assert.ok(await page.isChecked('input[name=frames]'));
});

pageTest('a key that is let go beside another drives no longer', rough, async ({ page }) => {
  await spawnRobot(page);
  await page.keyboard.down('w');
  await waitForNumber(page, TARGET, (value) => value > 0);
  await page.keyboard.down('Control');
  await page.keyboard.up('w');
  await waitForNumber(page, TARGET, (value) => value === 0);
});

pageTest('letters drive while a control has the focus that needs arrows', rough, async ({ page }) => {
  await spawnRobot(page);
  for (const control of ['#camera', '#speed', 'select[name=class]', STARTS, '#drive-speed']) {
    await page.focus(control);
    const before = await page.inputValue(control);
    await drive(page, 'e');
    assert.equal(await page.inputValue(control), before);
  }
});

pageTest('arrows move the speed slider while it has the focus, and not the robot', rough, async ({ page }) => {
  const sent = drives(page);
  await spawnRobot(page);
  assert.equal(await page.textContent('#drive output'), '40 %');
  await page.focus('#drive-speed');
  for (const key of ['ArrowRight', 'ArrowRight', 'ArrowUp', 'ArrowLeft']) await page.keyboard.press(key);
  assert.equal(await page.inputValue('#drive-speed'), '42');
  assert.equal(await page.textContent('#drive output'), '42 %');
  await drive(page, 'w');
  const move = (percent) =>
    `DRIVE {Normalized true} {LinearVelocity ${percent}} {LateralVelocity 0.0} {RotationalVelocity 0.0}`;
  // The browser reports what it sent later than the page shows what came of it.
  await until(() => sent.length >= 3, 'three lines');
  assert.deepEqual(sent, [move('0.0'), move('42.0'), move('0.0')]);
});

pageTest('arrows choose while a select has the focus by keyboard', rough, async ({ page }) => {
  const sent = drives(page);
  await spawnRobot(page);
  await page.focus('#canvas');
  await page.keyboard.press('Tab');
  for (const key of ['ArrowDown', 'ArrowDown']) await page.keyboard.press(key);
  assert.equal(await page.inputValue('#camera'), 'chase');
  assert.deepEqual(sent, []);
});

pageTest('each robot is spawned at a free start with a free name', rough, async ({ page }) => {
  await page.click('[data-tab=drive]');
  // At once, before the first one is in the world.
  for (let spawned = 0; spawned < 3; spawned++) await page.click('#spawn');
  // Their clients are served in any order.
  await until(async () => (await page.locator('[data-robot]:has-text("yours")').count()) === 3, 'three robots');
  const names = await page.locator('[data-robot] span').allTextContents();
  assert.deepEqual(names, ['Robot1', 'Robot2', 'Robot3']);
  for (const [name, x, y] of [
    ['Robot1', 0, 0],
    ['Robot2', 2, -2],
    ['Robot3', -2, 2],
  ]) {
    await page.locator('[data-robot]', { hasText: name }).dispatchEvent('click');
    await page.waitForSelector(`[data-robot][aria-pressed=true]:has-text("${name}")`, { state: 'attached' });
    await waitForNumber(page, X, (value) => Math.abs(value - x) < 0.5);
    await waitForNumber(page, Y, (value) => Math.abs(value - y) < 0.5);
  }
  assert.deepEqual(await options(page), [
    'PlayerStart_0 (taken)',
    'RobotStart1 (taken)',
    'RobotStart2 (taken)',
    'where you click on the map',
  ]);
  // Nothing is free but the map.
  await offers(page, STARTS, '');
  await offers(page, '[name=name]', 'Robot4');
  await page.click('#spawn');
  await page.waitForSelector('#view.placing');
  // The robot at the last start leaves it.
  await page.keyboard.down('w');
  await offers(page, STARTS, 'RobotStart2');
});

pageTest('what another client takes is not offered', rough, async ({ page, server }) => {
  await page.click('[data-tab=drive]');
  await offers(page, STARTS, 'PlayerStart_0');
  const other = await connectClient(
    server.port,
    'INIT {ClassName USARBot.P3AT} {Name Robot1} {Location 0.3,-0.6,0} {Rotation 0,0,0}',
  );
  await offers(page, STARTS, 'RobotStart1');
  await offers(page, '[name=name]', 'Robot2');
  assert.equal(await page.textContent('#name-hint'), '');
  await page.fill('[name=name]', 'Robot1');
  await page.waitForSelector('#name-hint:text("There is a robot named Robot1 already.")');
  await page.fill('[name=name]', 'Robot3');
  await page.waitForSelector('#name-hint', { state: 'hidden' });
  // A hint and no more.
  await page.fill('[name=name]', 'Robot1');
  await page.click('#spawn');
  await page.waitForSelector('[data-robot="1"]', { state: 'attached' });
  // What was chosen stays, also when it is taken.
  await page.selectOption(STARTS, 'PlayerStart_0');
  const now = await number(page, '#time');
  await waitForNumber(page, '#time', (value) => value > now + 0.3);
  assert.equal(await page.inputValue(STARTS), 'PlayerStart_0');
  other.end();
  await page.waitForFunction((starts) => document.querySelector(starts).options[0].text === 'PlayerStart_0', STARTS);
});

pageTest('a robot that is refused gives back its start and says why', rough, async ({ page, server }) => {
  const init = (index) => `INIT {ClassName USARBot.CasterSkidRobot} {Location ${10 + index},50,-0.2}`;
  await connectClient(server.port, ...Array.from({ length: 256 }, (_, index) => init(index)));
  await page.waitForSelector('[data-robot="255"]', { state: 'attached' });
  await page.click('[data-tab=drive]');
  await page.click('#spawn');
  await page.waitForSelector('#toasts :text("Robot1 was refused: the world holds 256 robots already")');
  await page.waitForFunction((starts) => document.querySelector(starts).options[0].text === 'PlayerStart_0', STARTS);
});

pageTest('a key that is held before the robot is there drives it', rough, async ({ page }) => {
  await page.click('[data-tab=drive]');
  await page.evaluate(() => {
    document.getElementById('spawn').click();
    window.dispatchEvent(new KeyboardEvent('keydown', { code: 'KeyW', key: 'w' }));
  });
  await waitForNumber(page, X, (value) => value > 0.1);
});

pageTest('a message that comes again is counted', rough, async ({ page }) => {
  let say = null;
  await page.routeWebSocket(/\/live$/, (socket) => {
    socket.connectToServer().onMessage((message) => socket.send(message));
    say = (said) => socket.send(JSON.stringify({ said }));
  });
  await page.reload();
  await page.waitForFunction(() => document.documentElement.dataset.state === 'live');
  for (const text of ['again', 'another', 'again', 'again']) say(text);
  await page.waitForSelector('#toasts :text-is("again (3 times)")');
  assert.deepEqual(await page.locator('#toasts p').allTextContents(), ['again (3 times)', 'another']);
});

pageTest('the keys drive all own robots together once that is chosen', rough, async ({ page }) => {
  const lines = drives(page);
  await spawnRobot(page, { robotClass: 'P3AT' });
  assert.deepEqual(await page.locator('select[name=own] option').allTextContents(), ['Robot1']);
  await spawnRobot(page, { robotClass: 'P3AT', start: 'RobotStart1' });
  // A robot that arrives later is driven again by the keys that are held.
  await until(async () => (await page.locator('[data-robot]:has-text("yours")').count()) === 2, 'two robots');
  await page.selectOption('select[name=own]', 'all together');
  await page.focus('#canvas');
  const count = (speed) =>
    lines.filter((line) => line === `DRIVE {Normalized true} {Left ${speed}.0} {Right ${speed}.0}`).length;
  const full = () => count(40);
  await page.keyboard.down('w');
  await until(() => full() === 2, 'both drive');
  const stops = count(0);
  await page.keyboard.up('w');
  // A key that is pressed again before that drives on without another line.
  await until(() => count(0) === stops + 2, 'both stop');
  // The other choice leaves the second one alone again.
  await page.selectOption('select[name=own]', 'Robot1');
  await page.focus('#canvas');
  await page.keyboard.down('w');
  await until(() => full() === 3, 'one drives');
  await page.keyboard.up('w');
  await until(() => count(0) === stops + 3, 'one stops');
  assert.equal(full(), 3, lines.join('; '));
});
