// A server of its own for each test, a browser, and what tests do with both.

import { spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync } from 'node:fs';
import net from 'node:net';
import { tmpdir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import readline from 'node:readline';
import { setTimeout as sleep } from 'node:timers/promises';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

export const root = resolve(dirname(fileURLToPath(import.meta.url)), '../..');
export const program = resolve(process.env.USARSIM ?? join(root, 'target/release/usarsim'));
export const pictures = join(root, 'target/screenshots');
mkdirSync(pictures, { recursive: true });

/** Longest wait for a condition, ms. Only a test that fails waits so long: a busy machine may be five times slower than an idle one. */
export const PATIENCE = 100_000;

/** Waits until a condition holds. Returns its value. `what` says, or returns at the end, what did not come. */
export async function until(condition, what = String(condition)) {
  for (const end = performance.now() + PATIENCE; performance.now() < end; await sleep(20)) {
    const value = await condition();
    if (value) return value;
  }
  throw new Error(`not so for ${PATIENCE / 1000} s: ${typeof what === 'function' ? what() : what}`);
}

/** Starts `usarsim serve` and waits until it is ready. `logged` waits for a text in what it writes to its log. */
export async function startServer(...options) {
  const folder = mkdtempSync(join(tmpdir(), 'usarsim-'));
  const ports = options.includes('--port') ? [] : ['--port', '0', '--http', '0'];
  const child = spawn(program, ['serve', '--json', ...ports, ...options], {
    cwd: folder,
    stdio: ['ignore', 'pipe', 'pipe'],
  });
  let log = '';
  child.stderr.on('data', (data) => (log = (log + data).slice(-100_000)));
  const [line] = await new Promise((ready, failed) => {
    readline.createInterface(child.stdout).once('line', (line) => ready([line]));
    child.once('exit', (code) => failed(new Error(`the server ended with ${code}`)));
    child.once('error', failed);
  });
  const { port, http } = JSON.parse(line);
  const stop = async (signal = 'SIGTERM') => {
    if (child.exitCode !== null || child.signalCode !== null) return;
    const ended = new Promise((resolve) => child.once('exit', resolve));
    child.kill(signal);
    await ended;
  };
  const logged = (text) => until(() => log.includes(text), `the server logs: ${text}`);
  return { folder, port, http, url: `http://127.0.0.1:${http}/`, stop, logged };
}

/**
 * Connects a client of the protocol that sends some lines, and waits until the server has executed them. `reaches` waits until its
 * robot's lines are of a simulated time, s, and returns the last one's.
 */
export async function connectClient(port, ...lines) {
  const socket = net.connect(port, '127.0.0.1');
  await new Promise((resolve, failed) => socket.once('connect', resolve).once('error', failed));
  socket.on('error', () => {});
  let time = -Infinity;
  // Two clients whose lines wait are served in any order.
  const served = new Promise((resolve) => {
    readline.createInterface(socket).on('line', (line) => {
      if (line.includes('{StartPoses')) resolve();
      time = Number(/^(?:STA|SEN) \{Time ([\d.]+)\}/.exec(line)?.[1] ?? time);
    });
    socket.once('close', resolve);
  });
  [...lines, 'GETSTARTPOSES'].forEach((line) => socket.write(`${line}\r\n`));
  await served;
  return {
    send: (line) => socket.write(`${line}\r\n`),
    end: () => socket.destroy(),
    reaches: async (seconds) => {
      await until(() => time >= seconds, `${seconds} s of simulated time`);
      return time;
    },
  };
}

/** Connects clients that spawn a robot each, and drive it. */
export async function connectRobots(port, count, robotClass = 'KUKA_YouBot') {
  for (let number = 0; number < count; number++) {
    const [x, y] = [-4 + 2 * (number % 5), -2.5 + 1.4 * Math.floor(number / 5)];
    const init = `INIT {ClassName USARBot.${robotClass}} {Name R${number}} {Location ${x},${y},-0.1}`;
    await connectClient(port, init, 'DRIVE {LinearVelocity 0.1} {LateralVelocity 0.1} {RotationalVelocity 0.5}');
  }
}

/** Debian's browser, which draws without a graphics card here. */
export function launchBrowser() {
  const executablePath =
    process.env.CHROMIUM ??
    ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
  const args = [
    '--no-sandbox',
    '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader',
    '--disable-features=LocalNetworkAccessChecks',
  ];
  return chromium.launch({ executablePath, args });
}

/**
 * Opens the page and waits until the world is shown. What goes to the console as an error is collected. A still picture takes two seconds of
 * two cores, so the quality is held at the least, but for tests that want another one.
 */
export async function openPage(browser, url, { door = false, quality = '1', ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, ...options });
  // Somebody has left the first screen in this tab.
  if (!door) await context.addInitScript(() => sessionStorage.setItem('usarsim.door', 'left'));
  await context.addInitScript((quality) => {
    if (localStorage.getItem('usarsim.quality') === null) localStorage.setItem('usarsim.quality', quality);
  }, quality);
  context.setDefaultTimeout(PATIENCE);
  const page = await context.newPage();
  const errors = [];
  page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
  page.on('pageerror', (error) => errors.push(String(error)));
  const begin = performance.now();
  await page.goto(url);
  await page.waitForFunction(() => document.documentElement.dataset.state === 'live');
  await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
  return { page, errors, seconds: (performance.now() - begin) / 1000 };
}

/** The number in an element. */
export async function number(page, selector) {
  return Number.parseFloat(await page.textContent(selector));
}

/** Waits until there is a number and it fits. */
export async function waitForNumber(page, selector, fits) {
  let value = Number.NaN;
  const isThere = async () => {
    value = await number(page, selector);
    return !Number.isNaN(value) && fits(value);
  };
  await until(isThere, () => `${selector} is ${value}, expected ${fits}`);
  return value;
}
