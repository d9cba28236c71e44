// The world as everyone sees it: its tree, its time, its map, and who did what.

import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { ABOVE, SLANTED, X, Y, pageTest, spawnRobot, waitForRobotInMiddle, waitForView } from './pagetest.mjs';
import { runnerImport } from 'vite';
import { connectClient, number, openPage, pictures, root, startServer, waitForNumber } from './server.mjs';

const { frameRate } = (await runnerImport(join(root, 'viewer/src/view/stopwatch.ts'))).module;

const rough = { serve: ['--map', 'rough'] };
const others = 'INIT {ClassName USARBot.P3AT} {Name Other} {Location 3,0,-0.1}';

const said = (page, text) => page.waitForSelector(`#toasts :text(${JSON.stringify(text)})`);
const map = (page, name) => page.waitForFunction((name) => document.getElementById('map').textContent === name, name);

pageTest('a robot is spawned from the first view', rough, async ({ page }) => {
  await page.click('[data-spawn=P3AT]');
  await page.waitForSelector('[data-robot="0"][aria-pressed=true]');
  await page.waitForSelector('#welcome', { state: 'hidden' });
  await page.keyboard.down('w');
  await waitForNumber(page, X, (value) => value > 0.1);
});

pageTest('a world that a program steps is only looked at', rough, async ({ page }) => {
  // The page of such a world has no port for controllers.
  await page.route('**/scene.json', async (route) => {
    const response = await route.fetch();
    await route.fulfill({ response, json: { ...(await response.json()), port: 0 } });
  });
  await page.reload();
  await page.waitForSelector('[data-watched] #world :text("No robot yet.")');
  for (const part of ['#panel', '#welcome', '#open-spawn']) await page.waitForSelector(part, { state: 'hidden' });
  await page.keyboard.press('n');
  await page.keyboard.press('?');
  const keys = await page.textContent('#dialog');
  assert.ok(keys.includes('Plots') && !keys.includes('Spawn a robot'), keys);
});

pageTest('a value of a sensor is shown and plotted by a click', rough, async ({ page }) => {
  await spawnRobot(page, { robotClass: 'P3AT' });
  await page.click('summary:text("GroundTruth GndTruth")');
  const value = '[data-value="GroundTruth GndTruth/position x"]';
  await page.keyboard.down('w');
  await waitForNumber(page, value, (number) => number > 0.2);
  await page.keyboard.up('w');
  await page.click(value);
  await page.waitForSelector('#plots:not([hidden]) .u-legend :text("Robot1 position x")');
  await page.click('[data-value=x]');
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#save-csv')]);
  const lines = readFileSync(await download.path(), 'utf8').split('\n');
  assert.equal(lines[0], 'time_s,value,number,unit');
  // The past of what the frames have is there at once, that of sensors begins with the click.
  const x = lines.filter((line) => line.includes('"Robot1 x"')).map((line) => Number(line.split(',')[2]));
  assert.ok(x.length > 10 && Math.abs(x[0]) < 0.05 && x.at(-1) > 0.2, `${x}`);
  // Another click plots it no longer.
  await page.click('[data-value=x]');
  await page.click(value);
  await page.waitForSelector('.chart', { state: 'detached' });
});

pageTest(
  'a page that may not control the world is told so, and drives',
  { serve: ['--control', 'nobody'] },
  async ({ page }) => {
    await page.waitForSelector('#pause[aria-disabled=true]');
    assert.equal(await page.getAttribute('#reset', 'title'), 'no page controls this world');
    await page.keyboard.press('Space');
    await said(page, 'not done: no page controls this world');
    await spawnRobot(page);
    await page.keyboard.down('w');
    await waitForNumber(page, X, (value) => value > 0.1);
    await page.keyboard.up('w');
  },
);

pageTest('the last minute can be looked at while the world goes on', rough, async ({ page }) => {
  await spawnRobot(page);
  await page.keyboard.down('w');
  await waitForNumber(page, X, (value) => value > 0.4);
  const now = await number(page, '#time');
  await page.locator('#timeline').evaluate((timeline) => {
    timeline.value = timeline.min;
    timeline.dispatchEvent(new Event('input'));
  });
  await page.waitForSelector('#mode[data-mode=past]');
  const then = await waitForNumber(page, '#time', (value) => value < now - 0.5);
  // The world goes on.
  await waitForNumber(page, '#last-time', (value) => value > now + 0.5);
  assert.equal(await number(page, '#time'), then);
  // The end of the line is the present.
  await page.locator('#timeline').evaluate((timeline) => {
    timeline.value = timeline.max;
    timeline.dispatchEvent(new Event('input'));
  });
  await page.waitForSelector('#timeline[data-live]');
  await waitForNumber(page, '#time', (value) => value > then + 0.5);
  await waitForNumber(page, X, (value) => value > 0.4);
});

pageTest('a log plays in the page, and the present comes back', rough, async ({ page }) => {
  const recording = await startServer('--map', 'arena', '--log', 'run.mcap');
  const client = await connectClient(
    recording.port,
    'INIT {ClassName USARBot.P3AT} {Name Recorded} {Start PlayerStart_0}',
    'DRIVE {Left 3} {Right 3}',
  );
  const { page: watching } = await openPage(page.context().browser(), recording.url);
  await waitForNumber(watching, '#time', (time) => time > 4);
  await watching.context().close();
  await recording.stop();
  client.end();
  await page.setInputFiles('#log-file', join(recording.folder, 'run.mcap'));
  await page.waitForSelector('#mode[data-mode=log]:text-is("run.mcap")');
  // So slowly that it does not end meanwhile, whatever the machine does beside.
  await page.selectOption('#speed', '0.1');
  await page.locator('#timeline').evaluate((timeline) => {
    timeline.value = '1.5';
    timeline.dispatchEvent(new Event('input'));
  });
  assert.equal(await page.textContent('#map'), 'arena');
  await page.waitForSelector('[data-robot]:has-text("Recorded")');
  const start = await waitForNumber(page, X, Number.isFinite);
  await waitForNumber(page, X, (value) => value > start + 0.02);
  await page.click('#pause');
  await page.waitForSelector('#pause:text-is("Resume")');
  // Neither the server's world nor its log is asked for anything from here.
  assert.ok((await page.isDisabled('#record')) && (await page.isDisabled('#reset')));
  await page.locator('#timeline').evaluate((timeline) => {
    timeline.value = '2';
    timeline.dispatchEvent(new Event('input'));
  });
  await waitForNumber(page, '#time', (time) => time === 2);
  await page.click('#step');
  await waitForNumber(page, '#time', (time) => time === 2.01);
  await page.click('#live');
  await map(page, 'rough');
  await page.waitForSelector('[data-robot]', { state: 'detached' });
  // Nobody has changed the map.
  assert.equal((await page.locator('#toasts').textContent()).includes('The map is now'), false);
  await page.setInputFiles('#log-file', {
    name: 'no.mcap',
    mimeType: 'application/octet-stream',
    buffer: Buffer.from('no log'),
  });
  await said(page, 'no.mcap: ');
});

pageTest('the maps to choose from have pictures', rough, async ({ page }) => {
  await page.click('#map');
  await page.waitForFunction(() => {
    const pictures = [...document.querySelectorAll('[data-map] img')];
    return pictures.length > 5 && pictures.every(({ complete, naturalWidth }) => complete && naturalWidth === 256);
  });
});

pageTest('a chosen map shows its materials in place of a robot', { serve: ['--map', 'arena'] }, async ({ page }) => {
  await spawnRobot(page);
  await page.click('#map-row');
  await page.waitForSelector('#map-facts:has-text("A step is 2 ms")');
  await page.waitForSelector('#map-facts tr:has-text("plywood")');
  await page.click('[data-robot]');
  await page.waitForSelector('#map-facts', { state: 'hidden' });
});

pageTest('the map is changed, and robots of this page stay', rough, async ({ page }) => {
  await spawnRobot(page);
  await page.click('#map');
  await page.click('[data-map=arena]');
  await map(page, 'arena');
  await said(page, 'You changed the map to arena');
  await page.waitForSelector('[data-robot]');
  await page.keyboard.down('w');
  await waitForNumber(page, X, (value) => value > 0.1);
});

pageTest('who resets the world of others is asked, and everyone is told', rough, async ({ page, server }) => {
  const { page: second } = await openPage(page.context().browser(), server.url);
  await connectClient(server.port, others);
  await page.waitForSelector('[data-robot]');
  await page.click('#reset');
  await page.waitForSelector('dialog:has-text("Robots of other people are here: Other.")');
  await page.click('dialog button:text("Cancel")');
  await page.click('#map');
  await page.click('[data-map=arena]');
  await page.click('dialog button:text("Cancel")');
  assert.equal(await page.textContent('#map'), 'rough');
  await page.click('#reset');
  await page.click('dialog button:text("Reset")');
  await said(page, 'You reset the world');
  await said(second, 'page 1 (127.0.0.1) reset the world');
  await second.click('#pause');
  await said(page, 'page 2 (127.0.0.1) paused the world');
  await second.selectOption('#speed', '2');
  await said(page, 'page 2 (127.0.0.1) set the real-time factor to 2');
  await page.waitForSelector('#world :text("2 pages are open")');
  await second.context().close();
});

pageTest('a robot of this page is dragged to another place while time stands still', rough, async ({ page }) => {
  await spawnRobot(page);
  await page.selectOption('#camera', 'top');
  await page.keyboard.press('g');
  await page.keyboard.press(' ');
  await page.waitForSelector('#pause[aria-pressed=true]');
  await waitForView(page, ABOVE);
  await waitForRobotInMiddle(page);
  const { x, y, width, height } = await page.locator('#canvas').boundingBox();
  const [middle, level] = [x + width / 2, y + height / 2];
  await page.mouse.move(middle, level);
  await page.mouse.down();
  await page.mouse.move(middle + 60, level + 40, { steps: 4 });
  await page.mouse.up();
  await page.keyboard.press(' ');
  await page.waitForFunction(
    ([x, y]) => Math.hypot(...[x, y].map((place) => Number(document.querySelector(place)?.textContent ?? 0))) > 0.1,
    [X, Y],
  );
  assert.equal(await page.locator('[data-robot]').count(), 1);
});

pageTest('commands are found by their names, and keys are listed', rough, async ({ page }) => {
  await page.keyboard.press('Control+k');
  await page.fill('dialog input', 'light dark');
  const before = await page.getAttribute('html', 'data-theme');
  await page.keyboard.press('Enter');
  assert.notEqual(await page.getAttribute('html', 'data-theme'), before);
  await page.keyboard.press('?');
  await page.waitForSelector('dialog :text("Pause or resume")');
  await page.keyboard.press('Escape');
  await page.waitForSelector('dialog', { state: 'hidden' });
});

pageTest('columns are resized by keys and keep their size', rough, async ({ page }) => {
  const width = () => page.locator('#world').evaluate((world) => world.offsetWidth);
  const before = await width();
  await page.focus('[data-resizes=world]');
  for (let press = 0; press < 3; press++) await page.keyboard.press('ArrowRight');
  assert.equal(await width(), before + 60);
  await page.reload();
  await page.waitForFunction(() => document.documentElement.dataset.state === 'live');
  assert.equal(await width(), before + 60);
});

pageTest(
  'a camera shows what it sees, and objects come and go',
  { serve: ['--map', 'hall'] },
  async ({ page, server }) => {
    const robot = await connectClient(server.port, 'INIT {ClassName USARBot.P3AT} {Name R1} {Location -3,0,-0.2}');
    await page.waitForSelector('[data-robot]', { state: 'attached' });
    await page.click('button:has-text("Show picture")');
    const shown = () => document.querySelector('.picture img')?.naturalWidth === 320;
    await page.waitForFunction(shown);
    const first = await page.getAttribute('.picture img', 'src');
    await page.waitForFunction((first) => document.querySelector('.picture img')?.src !== first, first);
    await page.screenshot({ path: join(pictures, 'camera.png') });

    const controller = await connectClient(
      server.port,
      'INIT {ClassName USARBotAPI.WorldController}',
      'CONTROL {Type Create} {ClassName WCCrateRed} {Name red_crate} {Location -1,0,-0.25} {Physics RigidBody}',
    );
    await page.waitForSelector('[data-object]:has-text("red_crate")', { state: 'attached' });
    await page.screenshot({ path: join(pictures, 'controller.png') });
    controller.end();
    await page.waitForSelector('[data-object]:has-text("red_crate")', { state: 'detached' });

    await page.click('#save');
    await page.waitForSelector('#toasts :text("saved the world at")');
    assert.ok(readdirSync(server.folder).includes('usarsim-hall.json'));
    await page.click('button:has-text("Hide picture")');
    await page.waitForSelector('.picture img', { state: 'hidden' });
    robot.end();
  },
);

pageTest('robots are listed by name, numbers as numbers', rough, async ({ page, server }) => {
  const names = ['Student10', 'Student2', 'ann', 'Student1'];
  const clients = [];
  for (const [index, name] of names.entries()) {
    const init = `INIT {ClassName USARBot.P3AT} {Name ${name}} {Location ${2 * index},0,-0.2}`;
    clients.push(await connectClient(server.port, init));
  }
  await page.waitForSelector('[data-robot="3"]', { state: 'attached' });
  const listed = await page.locator('[data-robot] span').allTextContents();
  assert.deepEqual(listed, ['ann', 'Student1', 'Student2', 'Student10']);
  for (const client of clients) client.end();
});

pageTest('a robot has the same colour when it is spawned again', rough, async ({ page }) => {
  const colour = () => page.locator('[data-robot] .swatch').evaluate(({ style }) => style.background);
  await spawnRobot(page, { robotClass: 'P3AT' });
  const first = await colour();
  await page.click('[data-value=x]');
  const marker = page.locator('.u-legend .u-series:nth-child(2) .u-marker');
  assert.equal(await marker.evaluate(({ style }) => style.borderColor || style.borderTopColor), first);
  await page.click('#remove');
  await page.waitForSelector('[data-robot]', { state: 'detached' });
  await page.fill('[name=name]', 'Robot1');
  await spawnRobot(page, { robotClass: 'P3AT' });
  await page.waitForSelector('[data-robot="1"]:has-text("Robot1")');
  assert.equal(await colour(), first);
});

pageTest('Home shows the whole map, and the list names the camera', rough, async ({ page }) => {
  await spawnRobot(page, { robotClass: 'P3AT' });
  const scale = () => page.textContent('#scale');
  const whole = async (mode, view) => {
    await page.keyboard.press('Home');
    await waitForView(page, view);
    await page.waitForFunction((mode) => document.querySelector('#camera').value === mode, mode);
  };
  await page.selectOption('#camera', 'top');
  await waitForView(page, ABOVE);
  await page.keyboard.press('g');
  await page.waitForFunction(() => document.querySelector('#scale').textContent.endsWith('cm'));
  await whole('top', ABOVE);
  await page.waitForFunction(() => / \d+ m$| ?\d+ m$/.test(document.querySelector('#scale').textContent));
  assert.match(await scale(), /\d m$/);
  for (const mode of ['follow', 'chase', 'robot']) {
    await page.selectOption('#camera', mode);
    await whole('orbit', SLANTED);
  }
});

for (const [name, offered] of [
  ['soccer', ['SoccerRobot', 'Nao', 'YouBot']],
  ['yard', ['Hummer', 'ATRV', 'AirRobot']],
  ['rough', ['YouBotArm', 'P3AT', 'AirRobot']],
]) {
  pageTest(`robots that suit the map ${name} are offered`, { serve: ['--map', name] }, async ({ page }) => {
    assert.deepEqual(await page.locator('.card strong').allTextContents(), offered);
    assert.equal(await page.inputValue('select[name=class]'), offered[0]);
    const drawn = () =>
      [...document.querySelectorAll('.card img')].filter(({ complete, naturalWidth }) => complete && naturalWidth > 0);
    await page.waitForFunction(`(${drawn})().length === 3`);
  });
}

pageTest('no frame rate is shown at rest', rough, async ({ page }) => {
  await page.waitForFunction(() => /^Picture quality \d of 5$/.test(document.querySelector('#rate').textContent));
  assert.deepEqual([frameRate(0, 0), frameRate(0, 60), frameRate(10, 50), frameRate(10, 5)], [null, null, null, 10]);
});
