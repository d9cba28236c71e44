// A robot is put where one clicks: its ghost is red where it cannot stand.

import assert from 'node:assert/strict';
import { ABOVE, countPixels, pageTest, setQuality, waitForPixels, waitForView } from './pagetest.mjs';
import { until } from './server.mjs';

const arena = { serve: ['--map', 'arena'] };

/** Chooses to place a robot by a click. */
async function startPlacing(page, robotClass) {
  await page.click('[data-tab=drive]');
  await page.selectOption('select[name=class]', robotClass);
  await page.selectOption('select[name=start]', '');
  await page.click('#spawn');
  await page.waitForSelector('#view.placing');
}

/** From and to which a pixel is red. */
const RED = [
  [150, 0, 0],
  [255, 90, 90],
];

/** Answers for the server. The page itself notes when it sends, as a busy machine brings its questions late. */
async function answerFits(page, questions, world) {
  await page.routeWebSocket(/\/live$/, (socket) => {
    const server = socket.connectToServer();
    socket.onMessage((message) => {
      const { fit } = JSON.parse(message);
      if (!fit) return server.send(message);
      questions.push(fit);
      const { stands } = world;
      socket.send(JSON.stringify({ fit: { ...fit, stands, why: stands ? null : 'inside wall-front' } }));
    });
  });
  await page.addInitScript(() => {
    const { send } = WebSocket.prototype;
    window.asked = [];
    WebSocket.prototype.send = function (text) {
      if (typeof text === 'string' && text.includes('"fit"')) window.asked.push(performance.now());
      return send.call(this, text);
    };
  });
  await page.reload();
  await page.waitForFunction(() => document.documentElement.dataset.state === 'live');
}

pageTest('a ghost is red where the robot cannot stand, and says why', arena, async ({ page }) => {
  const [questions, world] = [[], { stands: true }];
  await answerFits(page, questions, world);
  await setQuality(page, 1);
  await page.selectOption('#camera', 'top');
  await startPlacing(page, 'YouBotArm');
  await page.waitForSelector('#placing:has-text("Click where the robot should stand")');
  assert.equal(await page.locator('#toasts p').count(), 0);
  const { x, y, width, height } = await page.locator('#canvas').boundingBox();
  const move = (part) => page.mouse.move(x + width / 2, y + part * height, { steps: 5 });
  await move(0.7);
  await page.waitForSelector('#placing[data-stands=true]');
  const before = await countPixels(page, ...RED);
  world.stands = false;
  await move(0.35);
  await page.waitForSelector('#placing[data-stands=false]:has-text("A robot cannot stand here: inside wall-front")');
  await waitForPixels(page, before + 50, ...RED);
  // A click there is not taken.
  await page.mouse.down();
  await page.mouse.up();
  assert.ok(await page.isVisible('#view.placing'));
  world.stands = true;
  await move(0.7);
  await page.waitForSelector('#placing[data-stands=true]');
  await page.mouse.down();
  await page.mouse.up();
  await page.waitForSelector('[data-robot]');
  await page.waitForSelector('#placing', { state: 'hidden' });
  const asked = await page.evaluate(() => window.asked);
  assert.equal(asked.length, questions.length);
  const gaps = asked.slice(1).map((at, index) => at - asked[index]);
  assert.ok(Math.min(...gaps) > 60, `${gaps}`);
  assert.equal(questions[0].class, 'YouBotArm');
});

pageTest('the server says what is in the way of a robot', arena, async ({ page }) => {
  let [asked, answered] = [0, 0];
  await page.routeWebSocket(/\/live$/, (socket) => {
    const server = socket.connectToServer();
    socket.onMessage((message) => {
      asked += JSON.parse(message).fit ? 1 : 0;
      server.send(message);
    });
    server.onMessage((message) => {
      socket.send(message);
      answered += typeof message === 'string' && JSON.parse(message).fit ? 1 : 0;
    });
  });
  await page.reload();
  await page.waitForFunction(() => document.documentElement.dataset.state === 'live');
  await page.selectOption('#camera', 'top');
  await waitForView(page, ABOVE);
  await startPlacing(page, 'P3AT');
  const { x, y, width, height } = await page.locator('#canvas').boundingBox();
  // Somewhere on the way to the edge of the map is a wall.
  let isFound = false;
  for (let part = 0.5; part > 0.02 && !isFound; part -= 0.01) {
    const before = asked;
    await page.mouse.move(x + width / 2, y + part * height);
    await until(() => asked > before && answered === asked, 'the server answers for this place');
    isFound = /takes it/.test(await page.textContent('#placing'));
  }
  assert.ok(isFound);
});
