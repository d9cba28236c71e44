/** The page: what comes from the server goes to the state, the picture and the panels; commands go back. */

import './style.css';
import { Bar } from './panel/bar';
import { find, setText } from './panel/dom';
import { DrivePanel } from './panel/drive';
import { returnFocusAfterChoice } from './panel/keys';
import { PlotsPanel } from './panel/plots';
import { RobotsPanel } from './panel/robots';
import type { Placing } from './panel/spawn';
import { Toasts } from './panel/toasts';
import { WirePanel } from './panel/wire';
import { Live } from './protocol/live';
import { State } from './state';
import { View } from './view/view';

/** Between two updates of numbers, and of plots, ms. */
const PANEL_INTERVAL = 100;
const PLOT_INTERVAL = 250;
/** A press that moves farther is no click, px. */
const CLICK_REACH = 5;

const state = new State();
let placing: Placing = null;
let connected = false;

const view = new View(find<HTMLCanvasElement>('canvas'), find('labels'), (id) => state.robot(id));
const robots = new RobotsPanel(state, select);
const plots = new PlotsPanel(state);
const wire = new WirePanel();
const toasts = new Toasts(state);
const drive = new DrivePanel(state, place, say, select);

const live = new Live({
  scene(scene) {
    const before = state.scene;
    state.scene = scene;
    view.setScene(scene);
    drive.updateScene();
    if (before && before.map.name !== scene.map.name) say(`The server shows another map now: ${scene.map.name}`);
  },
  frame(frame) {
    state.frame = frame;
    view.setFrame(frame);
    plots.update();
    document.documentElement.dataset.state = 'live';
  },
  scan: (scan) => view.setScan(scan),
  status(status) {
    state.status = status;
    if (!connected) showBanner(null);
    connected = true;
    if (state.selected !== null && !state.robot(state.selected)) state.selected = null;
    if (state.selected === null && status.robots[0]) select(status.robots[0].id);
    robots.updateStatus();
    bar.updateStatus();
  },
  line: (line) => wire.line(line),
  said: say,
  lost() {
    connected = false;
    document.documentElement.dataset.state = 'lost';
    showBanner('The connection to the server is lost. Trying again …');
  },
});
const bar = new Bar(state, live, view);

function select(robot: number): void {
  state.selected = robot;
  robots.updateStatus();
  bar.look();
  view.turnTo(robot);
}

function place(next: Placing): void {
  placing = next;
  find('view').classList.toggle('placing', next !== null);
}

function say(text: string): void {
  wire.said(text);
  toasts.show(text);
}

/** What is wrong, or null when all is well again. */
function showBanner(text: string | null): void {
  const banner = find('banner');
  const wasLost = !banner.hidden;
  banner.hidden = text === null;
  if (text !== null) setText(banner, text);
  else if (wasLost) say('Connected again');
}

function showTab(name: string): void {
  for (const tab of document.querySelectorAll<HTMLElement>('[role=tab]')) {
    const chosen = tab.dataset.tab === name;
    tab.setAttribute('aria-selected', String(chosen));
    find(tab.dataset.tab ?? '').hidden = !chosen;
  }
  live.listenToWire(name === 'wire');
}

document.querySelectorAll<HTMLElement>('[role=tab]').forEach((tab) => {
  tab.onclick = () => showTab(tab.dataset.tab ?? '');
});

returnFocusAfterChoice();

let pressed: PointerEvent | null = null;
find('canvas').addEventListener('pointerdown', (event) => (pressed = event));
find('canvas').addEventListener('pointerup', (event) => {
  const moved = pressed && Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY);
  if (moved === null || moved > CLICK_REACH) return;
  const hit = view.pick(event.clientX, event.clientY);
  if (hit && 'place' in hit && placing) {
    placing(hit.place);
    place(null);
  } else if (hit && 'robot' in hit) select(hit.robot);
});

setInterval(() => plots.draw(), PLOT_INTERVAL);
setInterval(() => {
  bar.updateFrame();
  robots.updateFrame();
  drive.updateFrame();
  wire.draw();
  const rate = view.framesPerSecond();
  setText(find('rate'), `${rate} ${rate === 1 ? 'frame' : 'frames'}/s`);
  const metres = view.metresPer100Pixels();
  const round = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50].find((length) => length >= metres) ?? 100;
  const bar100 = find('scale').firstElementChild as HTMLElement;
  bar100.style.width = `${(100 * round) / metres}px`;
  setText(bar100, round < 1 ? `${Math.round(round * 100)} cm` : `${round} m`);
}, PANEL_INTERVAL);
