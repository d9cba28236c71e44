// Hands: objects and robots that are chosen, pulled, lifted, turned, put and removed.

import assert from 'node:assert/strict';
import { ABOVE, X, Y, pageTest, waitForView } from './pagetest.mjs';
import { connectClient, number, until, waitForNumber } from './server.mjs';

// The camera jumps, so that nothing moves away under the pointer.
const rough = { serve: ['--map', 'rough'], page: { reducedMotion: 'reduce' } };
const CRATE = 'CONTROL {Type Create} {ClassName WCCrate} {Name box} {Location 0,0,-0.26} {Physics RigidBody}';

/** Puts a crate at the origin, seen from above. */
async function crateFromAbove(page, server) {
  const controller = await connectClient(server.port, 'INIT {ClassName WorldController}', CRATE);
  await page.selectOption('#camera', 'top');
  await waitForView(page, ABOVE);
  await page.waitForSelector('[data-object]');
  await page.click('[data-object]:text-is("box")');
  return controller;
}

/** Pose of the chosen object as the tree writes it: x, y, z, m, roll, pitch, yaw, degrees. */
function place(page) {
  return page.evaluate(() => {
    const numbers = document.querySelector('[data-place]')?.textContent.match(/-?\d+\.\d+/g) ?? [];
    return numbers.slice(0, 6).map(Number);
  });
}

/** Waits until the chosen object's pose fits: metres and degrees. */
function waitForPlace(page, fits) {
  return until(async () => {
    const [x, y, z, roll, pitch, yaw] = await place(page);
    return fits({ x, y, z, roll, pitch, yaw });
  });
}

/** Presses the button on a thing in the middle of the view, once that is there. */
async function take(page) {
  const [x, y] = await middle(page);
  await until(async () => {
    // A pointer that does not move hovers over nothing.
    await page.mouse.move(x + 1, y);
    await page.mouse.move(x, y);
    return page.evaluate(() => document.querySelector('canvas.over-thing') !== null);
  }, 'something is in the middle');
  await page.mouse.down();
  return [x, y];
}

/** Middle of the view, where what is looked at is. */
async function middle(page) {
  const { x, y, width, height } = await page.locator('#canvas').boundingBox();
  return [x + width / 2, y + height / 2];
}

pageTest('a chosen object shows its facts and is pulled by a spring', rough, async ({ page, server }) => {
  const controller = await crateFromAbove(page, server);
  await page.waitForSelector('.facts:has-text("5 kg, plywood")');
  await waitForPlace(page, (at) => Math.abs(at.z + 0.25) < 0.01);
  const [x, y] = await take(page);
  await page.mouse.move(x + 90, y, { steps: 4 });
  await page.waitForSelector('.view-label.pull:text-matches("^[0-9.]+ N$")', { state: 'attached' });
  await waitForPlace(page, (at) => Math.hypot(at.x, at.y) > 0.2);
  // Shift lifts it.
  await page.keyboard.down('Shift');
  await page.mouse.move(x + 90, y - 120, { steps: 4 });
  await page.keyboard.up('Shift');
  await page.mouse.up();
  await page.waitForSelector('.view-label.pull', { state: 'detached' });
  await waitForPlace(page, (at) => Math.abs(at.z + 0.25) < 0.01);
  controller.end();
});

pageTest('keys alone pull, lift and turn the chosen thing, and let it go', rough, async ({ page, server }) => {
  const controller = await crateFromAbove(page, server);
  await waitForPlace(page, (at) => Math.abs(at.z + 0.25) < 0.01);
  await page.keyboard.press('Control+k');
  await page.fill('dialog input', 'pull by buttons');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.activeElement?.ariaLabel === 'Pull along x');
  const press = async (button, count) => {
    await page.focus(`#grasp [aria-label="${button}"]`);
    for (let number = 0; number < count; number++) await page.keyboard.press('Enter');
  };
  await press('Pull along x', 10);
  await press('Pull up', 12);
  await press('Turn to the right', 10);
  // It hangs 0.1 m below the place to which it is pulled.
  await waitForPlace(page, (at) => Math.abs(at.x - 0.5) < 0.02 && Math.abs(at.z + 0.75) < 0.02);
  await waitForPlace(page, (at) => Math.abs(at.yaw - 57.3) < 1);
  await page.focus('#let-go');
  await page.keyboard.press('Enter');
  await waitForPlace(page, (at) => Math.abs(at.z + 0.25) < 0.01);
  await page.waitForSelector('#let-go:disabled', { state: 'attached' });
  // While time stands still it is put exactly there.
  await page.click('#pause');
  await page.waitForSelector('#pause[aria-pressed=true]');
  const [before] = await place(page);
  await press('Pull against x', 4);
  await waitForPlace(page, (at) => Math.abs(at.x - before + 0.2) < 0.002);
  await page.click('#pause');
  await page.waitForSelector('#pause[aria-pressed=false]');
  // Escape lets go of what is held, too.
  await press('Pull up', 10);
  await page.waitForSelector('.view-label.pull', { state: 'attached' });
  await page.keyboard.press('Escape');
  await page.waitForSelector('.view-label.pull', { state: 'detached' });
  controller.end();
});

pageTest(
  'a finger that rests on a thing takes it, and asks for the menu if it does not move',
  {
    ...rough,
    page: { ...rough.page, hasTouch: true },
  },
  async ({ page, server }) => {
    const controller = await crateFromAbove(page, server);
    await waitForPlace(page, (at) => Math.abs(at.z + 0.25) < 0.01);
    const session = await page.context().newCDPSession(page);
    const touch = (type, ...points) =>
      session.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    const [x, y] = await middle(page);
    await touch('touchStart', [x, y]);
    await page.waitForSelector('canvas.grabbing');
    await touch('touchMove', [x + 90, y]);
    await waitForPlace(page, (at) => Math.hypot(at.x, at.y) > 0.2);
    await touch('touchStart', [x + 90, y], [x - 90, y]);
    await touch('touchMove', [x + 90, y - 150], [x - 90, y]);
    await waitForPlace(page, (at) => at.z < -0.3);
    await touch('touchEnd', [x + 90, y - 150]);
    await touch('touchEnd');
    await page.waitForSelector('.view-label.pull', { state: 'detached' });
    await touch('touchStart', [x, y]);
    await page.waitForSelector('canvas.grabbing');
    await touch('touchEnd');
    await page.waitForSelector('[role=menu]');
    controller.end();
  },
);

pageTest('an object is moved and turned exactly while time stands still', rough, async ({ page, server }) => {
  const controller = await crateFromAbove(page, server);
  await waitForPlace(page, (at) => Math.abs(at.z + 0.25) < 0.01);
  await page.click('#pause');
  await page.waitForSelector('#pause[aria-pressed=true]');
  const [x, y] = await take(page);
  await page.mouse.move(x + 80, y + 60, { steps: 4 });
  await waitForPlace(page, (at) => Math.hypot(at.x, at.y) > 0.3);
  await page.keyboard.down('Control');
  await page.mouse.move(x + 180, y + 60, { steps: 4 });
  // 100 pixels are a radian.
  await waitForPlace(page, (at) => Math.abs(at.yaw - 57.3) < 0.1);
  await page.keyboard.up('Control');
  await page.mouse.up();
  const put = await place(page);
  assert.ok(Math.abs(put[2] + 0.25) < 0.01, put.join());
  await page.click('#pause');
  await page.waitForSelector('#pause[aria-pressed=false]');
  const resumed = await number(page, '#time');
  await waitForNumber(page, '#time', (time) => time > resumed + 0.5);
  const after = await place(page);
  assert.ok(
    after.every((number, at) => Math.abs(number - put[at]) < 0.02),
    `${put} and ${after}`,
  );
  controller.end();
});

pageTest('a robot without a name that somebody else drives is pulled', rough, async ({ page, server }) => {
  const driver = await connectClient(server.port, 'INIT {ClassName USARBot.P3AT} {Location 0,0,-0.2}');
  await page.waitForSelector('[data-robot]', { state: 'attached' });
  await page.selectOption('#camera', 'top');
  await waitForView(page, ABOVE);
  const [x, y] = await take(page);
  await page.mouse.move(x + 150, y, { steps: 5 });
  await page.waitForFunction(
    ([x, y]) => Math.hypot(...[x, y].map((place) => Number(document.querySelector(place)?.textContent ?? 0))) > 0.05,
    [X, Y],
  );
  await page.mouse.up();
  driver.end();
});

pageTest('a menu puts a crate on the floor and removes it, by keys alone', rough, async ({ page }) => {
  await page.keyboard.press('Control+k');
  await page.fill('dialog input', 'put something');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#menu');
  await page.keyboard.press('ArrowDown');
  assert.equal(await page.evaluate(() => document.activeElement.textContent), 'Put a crate here');
  await page.keyboard.press('Enter');
  await page.waitForSelector('[data-object]:text-is("WCCrate-1")');
  await page.focus('[data-object]:text-is("WCCrate-1")');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#object:has-text("WCCrate-1")');
  await page.keyboard.press('u');
  await page.waitForSelector('#menu[aria-label=WCCrate-1]');
  await page.keyboard.press('Escape');
  await page.waitForSelector('#menu', { state: 'detached' });
  await page.keyboard.press('u');
  await page.keyboard.press('ArrowUp');
  await page.keyboard.press('Enter');
  await page.waitForSelector('[data-object]', { state: 'detached' });
});

pageTest(
  'a page that controls nothing takes and puts nothing',
  { ...rough, serve: [...rough.serve, '--control', 'nobody'] },
  async ({ page, server }) => {
    const controller = await crateFromAbove(page, server);
    await waitForPlace(page, (at) => Math.abs(at.z + 0.25) < 0.01);
    const [x, y] = await take(page);
    await page.mouse.move(x + 90, y, { steps: 4 });
    await page.mouse.up();
    await page.mouse.click(x + 91, y + 200, { button: 'right' });
    assert.equal(await page.locator('#menu').count(), 0);
    const { length, ...rest } = await place(page);
    assert.equal(length, 6);
    assert.ok(Math.hypot(rest[0], rest[1]) < 0.01);
    controller.end();
  },
);

pageTest('a right click on the floor offers what can be put there', rough, async ({ page }) => {
  const [x, y] = await middle(page);
  await page.mouse.click(x, y, { button: 'right' });
  await page.click('#menu button:text-is("Put a pallet here")');
  // It is drawn, too.
  await page.waitForSelector('.view-label.object:text-is("WCPallet-1")', { state: 'attached' });
  await page.mouse.click(x, y, { button: 'right' });
  await page.waitForSelector('#menu[aria-label=WCPallet-1]');
  await page.mouse.click(5, 5);
  await page.waitForSelector('#menu', { state: 'detached' });
});

pageTest('an object is copied, and its pose is plotted', rough, async ({ page, server }) => {
  const controller = await crateFromAbove(page, server);
  await page.waitForSelector('#object:has-text("box")');
  // Nobody knows the class of what others have named.
  assert.equal(await page.isVisible('#object button:text-is("Copy")'), false);
  controller.send(
    'CONTROL {Type Create} {ClassName WCCrate} {Name WCCrate-1} {Location 2,0,-0.26} {Physics RigidBody}',
  );
  await page.click('[data-object]:text-is("WCCrate-1")');
  await page.click('#object button:text-is("Copy")');
  await page.click('[data-object]:text-is("WCCrate-2")');
  await waitForPlace(page, ({ x, z }) => Math.abs(x - 2.6) < 0.01 && Math.abs(z + 0.25) < 0.01);
  await page.click('.value:has([data-object-value=z])');
  await page.waitForSelector('.chart:has-text("WCCrate-2 z")');
  assert.equal(await page.getAttribute('.value:has([data-object-value=z])', 'aria-pressed'), 'true');
  controller.end();
});
