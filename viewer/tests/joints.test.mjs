// Sliders, numbers and buttons that move the joints of an arm.

import assert from 'node:assert/strict';
import { ABOVE, pageTest, spawnRobot, waitForView } from './pagetest.mjs';
import { number, waitForNumber } from './server.mjs';

const rough = { serve: ['--map', 'rough'] };
/** The camera jumps, so that nothing moves away under the pointer. */
const still = { ...rough, page: { reducedMotion: 'reduce' } };
const ARM3 = '#joint-ArmJoint3';
/** Where joints are, as the tree says it. */
const JOINT3 = '[data-value=joint2]';

const value = (page, selector) => page.locator(selector).evaluate((input) => Number(input.value));

/** Waits until what a slider or a number shows fits. */
async function shows(page, selector, wanted, tolerance) {
  await page.waitForFunction(
    ([selector, wanted, tolerance]) => {
      const input = document.querySelector(selector);
      return input && !input.disabled && Math.abs(Number(input.value) - wanted) <= tolerance;
    },
    [selector, wanted, tolerance],
  );
}

async function spawnArm(page, start = 'PlayerStart_0') {
  await spawnRobot(page, { robotClass: 'YouBotArm', start });
  await page.waitForSelector('[data-joints]:not([disabled])');
}

/** The lines of the wire that the page sends and that have a text. */
function sentWith(page, text) {
  const lines = [];
  page.on('websocket', (socket) =>
    socket.on('framesent', ({ payload }) => {
      if (String(payload).includes(text)) lines.push(String(payload).trim());
    }),
  );
  return lines;
}

pageTest('sliders begin where the joints are, and an arrow key moves a small step', rough, async ({ page }) => {
  const sent = sentWith(page, 'SET {Type Joint}');
  await spawnArm(page);
  for (const joint of [1, 2, 3, 4, 5]) await shows(page, `#joint-ArmJoint${joint}`, 0, 0.02);
  const from = await number(page, JOINT3);
  await page.focus(ARM3);
  await page.keyboard.press('ArrowRight');
  await waitForNumber(page, JOINT3, (at) => Math.abs(at - from - 0.01) < 0.004);
  for (const key of ['ArrowRight', 'ArrowRight', 'ArrowLeft', 'End', 'Home']) await page.keyboard.press(key);
  await waitForNumber(page, JOINT3, (at) => Math.abs(at - from - 0.02) < 0.004);
  const targets = sent.map((line) => Number(/Params ([-\d.]+)/.exec(line)[1]));
  assert.ok(targets.length >= 1 && targets.every((target) => Math.abs(target) < 0.06), `${targets}`);
});

pageTest('a slider follows its joint, and shows it when its robot is chosen again', rough, async ({ page }) => {
  await spawnArm(page);
  await page.fill('#joint-ArmJoint3-number', '1');
  await page.keyboard.press('Enter');
  await waitForNumber(page, JOINT3, (at) => at > 0.97);
  await shows(page, ARM3, 1, 0.03);
  await spawnArm(page, 'RobotStart1');
  await page.waitForSelector('[data-robot="1"][aria-pressed=true]');
  await shows(page, ARM3, 0, 0.02);
  await page.selectOption('select[name=own]', 'Robot1');
  await page.waitForSelector('[data-robot="0"][aria-pressed=true]');
  await shows(page, ARM3, 1, 0.03);
  await shows(page, '#joint-ArmJoint3-number', 1, 0.03);
  await page.focus(ARM3);
  await page.keyboard.press('ArrowLeft');
  await shows(page, ARM3, 0.99, 0.03);
  assert.ok((await value(page, ARM3)) > 0.9);
});

pageTest('a joint has its unit, beside its number and in the tree', rough, async ({ page }) => {
  await spawnArm(page);
  const units = await page.locator('[data-joints] .unit').allTextContents();
  assert.deepEqual(units, ['rad', 'rad', 'rad', 'rad', 'rad']);
  assert.match(await page.getAttribute('#joint-ArmJoint1-number', 'title'), /^-?\d+\.\d°$/);
  const inTree = await page.locator('.value:has([data-value^=joint]) small').allTextContents();
  assert.deepEqual(inTree, ['rad', 'rad', 'rad', 'rad', 'rad', 'm', 'm']);
});

pageTest('a gripper has buttons in place of sliders of its fingers', rough, async ({ page }) => {
  const sent = sentWith(page, 'Gripper');
  await spawnArm(page);
  assert.equal(await page.locator('[id^=joint-][id*=Finger]').count(), 0);
  const finger = '[data-value=joint5]';
  await page.click('[data-grip=Open]');
  await waitForNumber(page, finger, (at) => at > 0.011);
  await page.waitForSelector('[data-joints] :text("100 % open")');
  await page.click('[data-grip=Close]');
  await waitForNumber(page, finger, (at) => at < 0.0005);
  const set = (opcode) => `SET {Type Gripper} {Name Gripper} {Opcode ${opcode}}`;
  assert.deepEqual(sent, [set('Open'), set('Close')]);
});

pageTest('angles are read and typed in degrees once that is chosen', rough, async ({ page }) => {
  const sent = sentWith(page, 'SET {Type Joint}');
  await spawnArm(page);
  await page.click('#angle-unit');
  assert.deepEqual(await page.locator('[data-joints] .unit').allTextContents(), ['°', '°', '°', '°', '°']);
  await page.fill('#joint-ArmJoint3-number', '45');
  await page.keyboard.press('Enter');
  await waitForNumber(page, JOINT3, (at) => Math.abs(at - Math.PI / 4) < 0.03);
  await shows(page, '#joint-ArmJoint3-number', 45, 2);
  await shows(page, ARM3, Math.PI / 4, 0.03);
  assert.ok(
    sent.some((line) => line.includes('{Name ArmJoint3} {Opcode Angle} {Params 0.7854}')),
    sent.join(),
  );
  await page.reload();
  await page.waitForSelector('#spawn');
  await spawnArm(page, 'RobotStart1');
  assert.equal(await page.textContent('[data-joints] .unit'), '°');
});

pageTest('a pose is kept and taken again, also by another robot of the class', rough, async ({ page }) => {
  await spawnArm(page);
  await page.fill('#joint-ArmJoint3-number', '0.8');
  await page.keyboard.press('Enter');
  // The sliders' positions are kept, and the tree may be a moment ahead of them.
  await shows(page, ARM3, 0.8, 0.02);
  await page.click('#keep-pose');
  await page.click('.poses button:text-is("Home")');
  await waitForNumber(page, JOINT3, (at) => Math.abs(at) < 0.02);
  await spawnArm(page, 'RobotStart1');
  await page.waitForSelector('[data-robot="1"][aria-pressed=true]');
  await page.click('.poses button:text-is("Pose 1")');
  await shows(page, ARM3, 0.8, 0.03);
  await page.evaluate(() => localStorage.setItem('usarsim.poses.YouBotArm', '[[1,2],"x",[null,0,0,0,0]]'));
  await page.reload();
  await page.waitForSelector('#spawn');
  await spawnArm(page, 'RobotStart2');
  assert.equal(await page.locator('.poses button:text-matches("^Pose ")').count(), 0);
});

pageTest('poses of the gripper are offered, and its hand is led by a drag', still, async ({ page }) => {
  await spawnArm(page);
  await page.click('.poses button:text-is("Carry")');
  await shows(page, '#joint-ArmJoint4', 1.79, 0.03);
  await page.click('.poses button:text-is("Pick")');
  await shows(page, '#joint-ArmJoint4', 0.87, 0.03);
  // By keys alone: up by 8 cm, down again, and up: on the floor the hand would be held by friction.
  const hand = async (where) => {
    await page.focus(`[aria-label="Hand ${where}"]`);
    for (let press = 0; press < 8; press++) await page.keyboard.press('Enter');
  };
  const isUp = () =>
    page.waitForFunction(() => Math.abs(Number(document.querySelector('#joint-ArmJoint4').value) - 0.87) > 0.1);
  await hand('up');
  await isUp();
  await hand('down');
  await shows(page, '#joint-ArmJoint4', 0.87, 0.03);
  await hand('up');
  await isUp();
  await page.selectOption('#camera', 'top');
  await waitForView(page, ABOVE);
  // The scale follows with the other numbers.
  const time = await page.textContent('#time');
  await page.waitForFunction((time) => document.querySelector('#time').textContent !== time, time);
  // The hand is 0.37 m ahead of the robot's middle, and ahead is to the right of the screen.
  const perMetre = await page.evaluate(() => {
    const bar = document.querySelector('#scale span');
    const [length, unit] = bar.textContent.split(' ');
    return bar.getBoundingClientRect().width / (Number(length) * (unit === 'cm' ? 0.01 : 1));
  });
  const { x, y, width, height } = await page.locator('#canvas').boundingBox();
  const [across, down] = [x + width / 2 + 0.37 * perMetre, y + height / 2];
  await page.mouse.move(across + 1, down);
  await page.mouse.move(across, down);
  await page.waitForSelector('canvas.over-thing');
  await page.mouse.down();
  await page.mouse.move(across, down + 0.1 * perMetre, { steps: 4 });
  await shows(page, '#joint-ArmJoint1', 0.45, 0.2);
  await page.mouse.up();
});
