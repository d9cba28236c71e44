// Programs in Python that drive the page's robots.

import assert from 'node:assert/strict';
import { pageTest } from './pagetest.mjs';
import { number, until, waitForNumber } from './server.mjs';

/** Opens the tab and runs a program, the world twice as fast as real time. */
async function run(page, program, { fast = true } = {}) {
  await page.keyboard.press('Escape');
  if (fast) await page.selectOption('#speed', '2');
  await page.click('[data-tab=code]');
  await page.fill('[name=program]', program);
  await page.click('#run');
}

/** Waits until the program has ended, and checks how. */
async function ends(page, how, text = '') {
  const status = await page.waitForSelector('[data-program=ended], [data-program=failed]', { state: 'attached' });
  const [said, is] = [await status.textContent(), await status.getAttribute('data-program')];
  assert.ok(is === how && said.includes(text), `${is}: ${said}`);
}

/** Waits for the first second of a world. */
const beginsAnew = (page) => waitForNumber(page, '#time', (time) => time < 1);
const printed = (page) => page.locator('#output li').allTextContents();

pageTest('a program drives a robot, with the line that waits lit', {}, async ({ page }) => {
  await run(
    page,
    'robot = await take("P3AT")\nawait robot.go(0.5)\nx = (await robot.pose())[0]\nprint(abs(x - 0.5) < 0.05)\n',
  );
  await page.waitForSelector('.numbers .lit:nth-child(2)');
  await ends(page, 'ended', 'Done');
  assert.deepEqual(await printed(page), ['True']);
  assert.equal(await page.locator('.numbers .lit').count(), 0);
  // Another run takes the same robot, and its sensors are there.
  await run(
    page,
    'robot = await take()\nreading = await robot.read("lms200")\nprint(robot, reading["Type"], len(reading["Range"]))\n',
  );
  await ends(page, 'ended', 'Done');
  assert.deepEqual(await printed(page), ['<robot Robot1> RangeScanner 181']);
});

pageTest('a wrong program says its line and what is wrong', {}, async ({ page }) => {
  for (const [program, wrong] of [
    ['text = """\nawait\n"""\nlist = [\n  1,\n]\nprint(unknown)', "line 7: NameError: name 'unknown' isn't defined"],
    ['def f(:\n  pass', 'line 1: SyntaxError: invalid syntax'],
    ['# await\nawait take("P3ATT")', 'line 2: RuntimeError: there is no class P3ATT'],
    ['await take()', 'line 1: RuntimeError: no robot is driven here: take("P3AT") spawns one'],
    ['await wait("1")', 'line 1: RuntimeError: seconds: expected a number, got "1"'],
    ['list = [0] * 100000000', 'line 1: MemoryError'],
    ['while True:\n  print("again")', 'printed 1000 lines without an order between them'],
    ['robot = await take("P3AT")\nawait robot.go(99)', 'line 2: RuntimeError: Robot1 comes no nearer: something'],
    ['robot = await take("P3AT")\nawait robot.move(Elbow=1)', 'line 2: RuntimeError: Robot1 has no joint Elbow'],
    ['await (await take("P3AT")).reach(1, 0, 0)', 'line 1: RuntimeError: Robot1 has no arm with a gripper'],
    ['await (await take("P3AT")).read("Nose")', 'line 1: RuntimeError: nothing of "Nose" came in 5 s'],
  ]) {
    await run(page, program);
    await ends(page, 'failed');
    assert.ok((await page.textContent('[data-program]')).startsWith(wrong), await page.textContent('[data-program]'));
  }
});

pageTest('a program that only computes is stopped, and the page goes on', {}, async ({ page }) => {
  await run(page, 'robot = await take("P3AT")\nawait robot.drive(0.3)\nwhile True:\n  pass', { fast: false });
  await page.waitForSelector('[data-robot]');
  await ends(page, 'failed', 'It computed for 10 s without an order');
  // Its robot stands.
  await page.waitForFunction(
    () => Math.abs(Number(document.querySelector('[data-value=forward]')?.textContent)) < 0.01,
  );
  assert.ok((await number(page, '[data-value=x]')) > 0.5);
  // One that gives orders without an end keeps the page free, too.
  await run(page, 'robot = await take()\nfor i in range(2000):\n  await robot.stop()\nprint(await now())', {
    fast: false,
  });
  const before = await number(page, '#time');
  await ends(page, 'ended', 'Done');
  assert.ok(Number((await printed(page))[0]) > before + 0.5);
  await run(page, 'while True:\n  await wait(0.1)', { fast: false });
  await page.waitForSelector('.numbers .lit:nth-child(2)');
  await page.click('#end-program');
  await ends(page, 'ended', 'Stopped');
});

pageTest(
  'a program ends when its robot leaves or its world begins anew, and the page goes on',
  {},
  async ({ page }) => {
    const waits =
      'robot = await take("YouBotArm")\nprint(await robot.grip())\nwhile True:\n  await robot.move(ArmJoint1=2.9)\n  await robot.move(ArmJoint1=-2.9)';
    await run(page, waits, { fast: false });
    await page.waitForSelector('.numbers .lit:nth-child(4)');
    await page.click('[data-tab=drive]');
    await page.click('#remove');
    await page.waitForSelector('[data-program=failed]', { state: 'attached' });
    assert.match(
      await page.textContent('[data-program]'),
      /^line [45]: RuntimeError: the robot Robot1 of this page is not/,
    );
    await run(page, 'await wait(1000)', { fast: false });
    await page.waitForSelector('.numbers .lit');
    await page.click('#reset');
    await ends(page, 'failed', 'The world began anew');
    await waitForNumber(page, '#time', (time) => time > 1);
  },
);

pageTest('a program that is still loaded when the world begins anew runs in the new one', {}, async ({ page }) => {
  await waitForNumber(page, '#time', (time) => time > 2);
  let load;
  await page.route('**/micropython*.wasm', (route) => (load = () => route.continue()));
  await run(page, 'robot = await take("P3AT")\nawait robot.go(0.1)', { fast: false });
  await until(() => load, 'Python is loaded');
  await page.click('#reset');
  await beginsAnew(page);
  await load();
  await ends(page, 'ended', 'Done');
});

pageTest(
  'on a slow page a program goes and turns as far as it says',
  { serve: ['--map', 'smooth'] },
  async ({ page }) => {
    await page.evaluate(() =>
      setInterval(() => {
        for (const end = performance.now() + 250; performance.now() < end;);
      }, 350),
    );
    await run(
      page,
      `robot = await take("P3AT")
begin = await robot.pose()
await robot.go(0.5)
await robot.turn(1.0)
end = await robot.pose()
print(end[0] - begin[0] - 0.5, end[5] - begin[5] - 1.0)
robot = await take("KUKA_YouBot")
await robot.go_to(1.5, -2.4, 0.3)
end = await robot.pose()
print(end[0] - 1.5, end[1] + 2.4, end[5] - 0.3)`,
    );
    await ends(page, 'ended', 'Done');
    const [skid, mecanum] = (await printed(page)).map((line) => line.split(' ').map(Number));
    assert.ok(Math.abs(skid[0]) < 0.04 && Math.abs(skid[1]) < 0.03, skid.join());
    assert.ok(Math.max(...mecanum.map(Math.abs)) < 0.011, mecanum.join());
  },
);

pageTest('each example does what it says', { serve: ['--map', 'hall'] }, async ({ page }) => {
  await run(page, '');
  await ends(page, 'ended', 'Done');
  for (const [example, said] of [
    ['A square', /^side 4: x -?0\.\d\d y -?0\.\d\d$/],
    ['Follow the wall', /^half a minute is over$/],
    ['Pick the cube', /^the cube is in the hand$/],
  ]) {
    await page.selectOption('[name=example]', example);
    await page.click('#reset');
    await beginsAnew(page);
    await page.click('#run');
    await ends(page, 'ended', 'Done');
    assert.match((await printed(page)).at(-1), said);
  }
  await page.click('[data-object]:text-is("cube")');
  const height = async () => -((await page.textContent('[data-place]')).match(/-?\d+\.\d+/g)?.[2] ?? 0);
  await until(async () => (await height()) > 0.15, 'the cube is lifted');
});
