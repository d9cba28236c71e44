/** The page: what comes from the server goes to the state, the picture and the panels; commands go back. */

import './style.css';
import './icons.css';
import { type Action, listenToKeys } from './actions';
import { Board } from './panel/board';
import { CodePanel } from './panel/code';
import { showCommands, showKeys } from './panel/commands';
import { ContextMenu } from './panel/context';
import { askToken } from './panel/dialog';
import { find, remember, remembered, setText } from './panel/dom';
import { Door } from './panel/door';
import { DrivePanel } from './panel/drive';
import { Grasp } from './panel/grasp';
import { Hands, type Thing } from './panel/hands';
import { focusView, returnFocusAfterChoice } from './panel/keys';
import { Leading } from './panel/leading';
import { MapPanel } from './panel/map';
import { changeMap, offerMaps } from './panel/maps';
import { Mission } from './panel/mission';
import { plainNotice } from './panel/notices';
import { ObjectPanel } from './panel/object';
import { Opening } from './panel/open';
import { Pace } from './panel/pace';
import { WIDE, buildFrame, buildSheets, buildSplitters, buildTabs } from './panel/panes';
import { Pictures } from './panel/pictures';
import { PlayBar, othersAgree } from './panel/play';
import { PlotsPanel } from './panel/plots';
import { Pointer } from './panel/pointer';
import { Sharing } from './panel/share';
import { suggestions } from './panel/suggest';
import { Toasts } from './panel/toasts';
import { Tools } from './panel/tools';
import { victimBoxes } from './panel/victims';
import { Welcome } from './panel/welcome';
import { WirePanel } from './panel/wire';
import { WorldPanel } from './panel/world';
import { type Link, readLink } from './link';
import { Playback } from './playback';
import type { Frame } from './protocol/frame';
import { Hand } from './protocol/hand';
import { Live, type Status } from './protocol/live';
import { network } from './protocol/network';
import type { Scene } from './protocol/scene';
import type { Transport } from './protocol/transport';
import { State } from './state';
import { QUALITIES, RUNGS } from './view/quality';
import { type Quality, View } from './view/view';

/**
 * Intervals between two updates of numbers, ms, and of plots. Without a graphics card each costs as much as a picture, so there are fewer while
 * a still picture is drawn.
 */
const PANEL_INTERVAL = { hardware: 100, software: 250, refining: 1000 };
const PLOT_INTERVAL = 250;
/** Interval between two looks at own robots and gamepads, ms. */
const DRIVE_INTERVAL = 100;
/** Distance of a copy of a robot, which stands beside what is in its way, m. */
const COPY_DISTANCE = 1;
/** Moments of the past that a new plot begins with. */
const PLOT_PAST = 600;

/** Way to the server. */
const transport: Transport = network;
const state = new State();
let connected = false;
/** Wishes of the page's address, until they are shown. */
let link = readLink(location.hash);
let isMapAsked = false;
/** The moment of a log that a link asks for, until that log is opened. */
let moment: Link['log'] = null;

const view = new View(
  find<HTMLCanvasElement>('canvas'),
  find('labels'),
  (id) => state.known(id),
  (number) => state.object(number),
  (id) => state.colourOf(id),
);
const playback = new Playback(transport.sceneOfLog, {
  scene: showScene,
  objects(objects) {
    state.spawned = objects;
    view.renewObjects();
  },
  robots: (robots) => (state.met = robots),
  frame: showFrame,
  scan(scan) {
    view.setScan(scan);
    plots.takeScan(scan);
  },
  picture: (picture) => pictures.take(picture),
  status: showStatus,
  line: (line) => wire.line(line),
  reading: (reading) => state.takeReading(reading),
  jumped() {
    state.forgetSensors();
    view.jump();
  },
  changed() {
    state.isPresent = playback.mode === 'live';
    if (moment && playback.logName === moment.name) {
      playback.goTo(moment.time);
      moment = null;
    }
    play.update();
    drive.updateMode();
    welcome.update();
    mission.update();
    door.update();
  },
  present(frame) {
    plots.push(frame);
    mission.takeFrame(frame);
    code.takeFrame(frame);
  },
  refilled: () => plots.refill(),
  said: say,
  shownTime: () => state.frame?.time ?? 0,
});
const plots = new PlotsPanel(state, () => playback.past(PLOT_PAST));
const hand = new Hand(transport, (why) => say(`The client of the typed lines has left: ${why}`));
const wire = new WirePanel(
  (line) => {
    if (!state.isPresent) say('The page shows the past: the line is not sent.');
    else if (!drive.sendLine(line)) hand.say(line);
  },
  () => suggestions(drive.robotClass, state.scene),
);
const toasts = new Toasts();
const pace = new Pace();
const tools = new Tools(state, view);
/** The client whose lines pull, put and remove things. */
const controller = new Hand(transport, (why) => say(`The client of this page's hands has left: ${why}`), [
  'INIT {ClassName WorldController} {Name hands}',
]);
const hands = new Hands(state, (line) => controller.say(line), whyRefused);
const menu = new ContextMenu(state, view, hands, {
  choose,
  look: (mode) => tools.look(mode),
  spawnAt: (place) => drive.spawnHere(place),
  copyRobot,
  remove: removeChosen,
});
const objectPanel = new ObjectPanel(state, hands, {
  look: (object) => view.lookAtObject(object),
  remove: removeChosen,
});
const mapPanel = new MapPanel(state);
const leading = new Leading(
  state,
  (positions) => drive.moveJoints(positions),
  (led) => view.showLed(led),
);
const pointer = new Pointer(
  state,
  view,
  hands,
  leading,
  choose,
  (hit, x, y) => menu.open(hit, x, y),
  (fit) => live.askFit(fit),
);
const drive = new DrivePanel(
  state,
  (placing) => {
    pointer.place(placing);
    if (placing) showSheet(null);
  },
  say,
  (robot, isNew) => {
    select(robot);
    // A scenario has a view of its own.
    if (isNew && !state.scene?.scenario?.camera) view.fit(robot);
    if (isNew && WIDE.matches && remembered('plots') !== 'closed') showPlots(true);
  },
  // What drives is in the view, and in the present.
  () => {
    showSheet(null);
    if (playback.mode !== 'live') playback.goLive();
  },
  (robotClass) => live.classOf(robotClass),
  transport,
);
const grasp = new Grasp(state, hands);
const code = new CodePanel(state, drive, () => live.echo());
const sharing = new Sharing(state, view, playback, say);
const board = new Board(state);
const mission = new Mission(state, {
  enter: enterScenario,
  again: () => find('reset').click(),
  others: () => door.show(),
  reached: (goals) => view.setReached(goals),
  rival: (robotClass, pose) => view.showRival(robotClass, pose),
});
const welcome = new Welcome(
  state,
  (robotClass) => drive.spawnAnywhere(robotClass),
  (robotClass) => void live.classOf(robotClass),
);

const live = new Live(transport, {
  scene: (scene) => playback.takeScene(scene),
  classCame() {
    // The next frame shows its robots; one of the past has come already.
    if (state.frame && playback.mode === 'past') view.setFrame(state.frame);
    welcome.update();
    world.update();
  },
  objects: (objects) => playback.takeObjects(objects),
  frame: (frame, bytes) => playback.takeFrame(frame, bytes),
  past: (past) => playback.takePast(past),
  scan: (scan) => playback.takeScan(scan),
  picture: (picture) => playback.takePicture(picture),
  status(status) {
    if (!connected) showBanner(null);
    connected = true;
    playback.takeStatus(status);
    door.takeStatus(status);
  },
  line: (line) => playback.takeLine(line),
  reading: (reading) => playback.takeReading(reading),
  fit: (answer) => pointer.takeFit(answer),
  said(text) {
    wire.said(text);
    const plain = plainNotice(text, namesOf, (line) => state.ownInits.has(line));
    if (plain !== null) toasts.show(plain);
  },
  lost() {
    connected = false;
    document.documentElement.dataset.state = 'lost';
    setText(find('mode'), 'not connected');
    find('mode').dataset.mode = 'lost';
    showBanner('The connection to the server is lost. Trying to connect again …');
  },
  refused(hadToken) {
    document.documentElement.dataset.state = 'refused';
    void askToken(hadToken).then(() => live.connect());
  },
});
const play = new PlayBar(state, live, playback);
new Opening(transport, {
  log: (file) => void playback.open(file),
  robot(robotClass, place) {
    // The form offers the class when it is here.
    void live.classOf(robotClass).then((came) => {
      if (!came) return say(`The server does not send the class ${robotClass}: try again`);
      drive.updateScene();
      if (place) drive.spawnAt(robotClass, place);
      else drive.spawnAnywhere(robotClass);
    });
  },
  map: (name) => void changeMap(state, live, name),
  groundAt: (x, y) => view.groundAt(x, y),
  say,
  refused: whyRefused,
});
const door = new Door(state, playback, transport, {
  start: (name) => void startScenario(name),
  refused: whyRefused,
  openLog: () => find('log-file').click(),
  say,
});
const pictures = new Pictures(
  state,
  (robots) => live.listenToCameras(robots),
  (robot) => {
    select(robot);
    tools.swapRobotsView();
  },
  (picture) => {
    const [robot, sensor] = [state.robotState(picture.robot), state.classOf(picture.robot)?.sensors[picture.sensor]];
    const victims = (state.scene?.map.sights ?? []).filter(({ kind }) => kind === 'Victims');
    if (!robot || !sensor || victims.length === 0) return [];
    return victimBoxes(picture, sensor, robot, victims, (from, to, near) => view.sees(from, to, near));
  },
);
const world = new WorldPanel(
  state,
  pictures,
  {
    select,
    chooseObject(number) {
      choose({ object: number });
      view.lookAtObject(number);
    },
    chooseMap: () => choose('map'),
    lookAt: (place) => view.lookAtPlace(place),
    isPlotted: (robot, key) => plots.has(robot, key),
    plot(robot, value) {
      plots.toggle(robot, value);
      showWhatIsPlotted();
    },
    isPlottedOfObject: (object, key) => plots.hasOfObject(object, key),
    plotOfObject(object, value) {
      plots.toggleOfObject(object, value);
      showWhatIsPlotted();
    },
    expanded: (robots) => live.listenToRobots(robots),
  },
  openSpawn,
);

function showScene(scene: Scene): void {
  const before = state.scene;
  state.scene = scene;
  state.selected = state.chosenObject = null;
  state.forgetSensors();
  // After a lost connection the same world may come again; what comes after a log is another one.
  if (before?.map.name !== scene.map.name || !state.isPresent) pictures.end();
  view.setScene(scene);
  // The starts of a scenario are its own: its robots have no place elsewhere.
  const wasPlayed = before?.scenario && state.isPresent && playback.mode === 'live';
  if (wasPlayed && before.scenario?.name !== scene.scenario?.name) drive.leaveAll();
  drive.updateScene();
  mission.update();
  if (entering && state.isPresent && scene.scenario?.name === entering.name) entering.isHere = true;
  document.documentElement.toggleAttribute('data-watched', state.isWatched);
  setText(find('map'), scene.map.name);
  // A log that is opened or closed changes no map.
  const isPresent = state.isPresent && playback.mode === 'live';
  if (isPresent && before && before.map.name !== scene.map.name) say(`The map is now ${scene.map.name}`);
}

/** The reason why this page may not change what is in the world. */
function whyRefused(): string | null {
  return state.isWatched ? 'this page shows the world of another program' : live.refused;
}

/** The scenario whose robots come with the first status of its world: it says which robots are there already. */
let entering: { name: string; isHere: boolean } | null = null;

/** Begins a scenario anew, with its robots driven from this page. */
async function startScenario(name: string): Promise<void> {
  const what = 'leave, or start again where the scenario has a place for them';
  if (!(await othersAgree(state, 'Begin a scenario?', what, 'Begin'))) return;
  entering = { name, isHere: false };
  drive.leaveAll();
  live.control({ scenario: name });
}

/** Brings the robots of the scenario that is played, to be driven from this page. */
function enterScenario(): void {
  const { scenario, league } = state.scene ?? {};
  const team = league?.teams[0]?.name ?? null;
  for (const { class: robotClass, name } of scenario?.robots ?? []) {
    drive.spawn({ robotClass, name, place: { start: name }, team });
  }
}

function showStatus(status: Status): void {
  const { status: before } = state;
  if (before && before.resets !== status.resets) state.forgetSensors();
  if (before && (before.resets !== status.resets || before.scene !== status.scene)) pictures.end();
  state.status = status;
  if (state.selected !== null && !state.robot(state.selected)) state.selected = null;
  if (state.selected === null && status.robots[0]) select(status.robots[0].id);
  world.update();
  play.update();
  board.update();
  mission.update();
  welcome.update();
  if (link) followLink(link, status);
  if (!entering?.isHere) return;
  entering = null;
  enterScenario();
}

/** Shows what the page's address asks for: another map first, then robots where none are, and the camera. */
function followLink({ map, robots, camera, log }: Link, status: Status): void {
  const { scene } = state;
  if (!scene || !state.isPresent) return;
  const mayAct = !whyRefused() && scene.league === null && status.robots.length === 0;
  if (mayAct && map !== null && map !== scene.map.name && scene.maps.some(({ name }) => name === map)) {
    if (!isMapAsked) live.control({ map });
    // The status of the other map comes later.
    isMapAsked = true;
    return;
  }
  link = null;
  if (camera) view.setViewpoint(camera);
  if (log) say(`Drop ${log.name} here to see it at ${log.time.toFixed(1)} s`);
  moment = log;
  if (!mayAct) return;
  robots.forEach(({ robotClass, location, yaw }, index) => {
    drive.spawn({ robotClass, name: `Robot${index + 1}`, place: { location, yaw }, team: null });
  });
}

function showFrame(frame: Frame): void {
  state.frame = frame;
  if (state.chosenObject !== null && !state.objectPose(state.chosenObject)) choose(null);
  leading.follow();
  view.setFrame(frame);
  if (playback.mode === 'log') plots.push(frame);
  plots.showMoment(playback.mode === 'live' ? null : frame.time);
  document.documentElement.dataset.state = 'live';
}

/** Chooses a robot, an object or the map; null for none of these but the robot that was chosen last. */
function choose(thing: Thing | 'map' | null): void {
  state.isMapChosen = thing === 'map';
  if (thing && thing !== 'map' && 'robot' in thing) return select(thing.robot);
  state.chosenObject = thing === 'map' ? null : (thing?.object ?? null);
  view.chooseObject(state.chosenObject);
  world.update();
}

function select(robot: number): void {
  state.selected = robot;
  state.chosenObject = null;
  state.isMapChosen = false;
  view.chooseObject(null);
  drive.driveIfOwn(robot);
  world.update();
  view.select(robot);
  tools.look();
}

function say(text: string): void {
  wire.said(text);
  toasts.show(text);
}

/** The robots of a connection. */
function namesOf(connection: number): string | null {
  const robots = (state.status?.robots ?? []).filter((robot) => robot.connection === connection);
  return robots.map(({ id }) => state.nameOf(id)).join(', ') || null;
}

/** Shows a problem; null when it is over. */
function showBanner(text: string | null): void {
  const banner = find('banner');
  const wasLost = !banner.hidden;
  banner.hidden = text === null;
  if (text !== null) setText(banner, text);
  else if (wasLost) say('Connected again');
}

function removeChosen(): void {
  if (state.chosenObject !== null) hands.remove(state.chosenObject);
  else if (state.selected !== null) live.control({ remove: state.selected });
  else say('Nothing is chosen');
}

function pullByButtons(): void {
  showTab('drive');
  if (!grasp.open()) say(whyRefused() ?? 'Nothing is chosen');
}

/** Spawns another robot of the chosen one's class beside it. */
function copyRobot(): void {
  const [robot, shown] = [state.robot(state.selected), state.robotState(state.selected)];
  if (!robot || !shown) return;
  const [x, y, z] = shown.pose;
  drive.spawnAt(robot.class, [x, y + COPY_DISTANCE, z]);
}

function showPlots(shown: boolean): void {
  find('plots').hidden = !shown;
  document.querySelector<HTMLElement>('[data-resizes=plots]')?.toggleAttribute('hidden', !shown);
  find('toggle-plots').setAttribute('aria-pressed', String(shown));
  if (shown && plots.isEmpty()) plots.plotFirst();
}

function showWhatIsPlotted(): void {
  if (!plots.isEmpty()) showPlots(true);
}

/** Opens or closes the plots, as a person wants it: on a wide screen they open by themselves otherwise. */
function togglePlots(): void {
  showPlots(find('plots').hidden === true);
  remember('plots', find('plots').hidden ? 'closed' : 'open');
}

function plotFirst(): void {
  showPlots(true);
  plots.plotFirst();
}

function openSpawn(): void {
  showTab('drive');
  if (document.body.dataset.sheet) showSheet('drive');
  drive.focusForm();
}

/** Returns what does something at times that are so far apart, ms. */
function every(interval: () => number, run: () => void): (now: number) => void {
  let last = -Infinity;
  return (now) => {
    if (now - last < interval()) return;
    last = now;
    run();
  };
}

function panelInterval(): number {
  if (!view.isSoftware) return PANEL_INTERVAL.hardware;
  return view.isRefining ? PANEL_INTERVAL.refining : PANEL_INTERVAL.software;
}

/** Brings the numbers of all panels up to date. */
function showNumbers(): void {
  play.updateTime();
  pace.update(state.isPresent ? state.status : null);
  world.updateValues();
  objectPanel.update();
  grasp.update();
  mapPanel.update();
  tools.updateDepths();
  drive.followJoints();
  wire.draw();
  const rate = view.framesPerSecond();
  setText(find('rate'), `Picture quality ${view.quality} of 5${rate === null ? '' : ` · ${rate} fps`}`);
  const metres = view.metresPer100Pixels();
  const round = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50].find((length) => length >= metres) ?? 100;
  const bar100 = find('scale').firstElementChild as HTMLElement;
  bar100.style.width = `${(100 * round) / metres}px`;
  setText(bar100, round < 1 ? `${Math.round(round * 100)} cm` : `${round} m`);
}

function setTheme(dark: boolean): void {
  document.documentElement.dataset.theme = dark ? 'dark' : 'light';
  remember('theme', dark ? 'dark' : 'light');
}

function setQuality(quality: Quality | 'auto'): void {
  view.setQuality(quality);
  remember('quality', String(quality));
}

const showTab = buildTabs((tab) => live.listenToWire(tab === 'wire'));
const showSheet = buildSheets(showTab, showPlots);
buildSplitters();
buildFrame();
void door.load();
const preferred = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
setTheme((remembered('theme') ?? preferred) === 'dark');
setQuality(QUALITIES.find((quality) => String(quality) === remembered('quality')) ?? 'auto');
returnFocusAfterChoice();

const press = (id: string) => () => find(id).click();
const actions: Action[] = [
  { name: 'Commands', shown: 'Ctrl K', run: () => showCommands(possible()) },
  { name: 'Keys', key: '?', run: () => showKeys(possible()) },
  { name: 'Pause or resume', key: ' ', shown: 'space', run: press('pause') },
  { name: 'Step 10 ms', key: '.', run: press('step') },
  { name: 'A frame back, into the past', key: ',', run: () => playback.goBack() },
  { name: 'Back to live', key: 'End', run: press('live') },
  { name: 'Spawn a robot', key: 'n', shown: 'N', drives: true, run: openSpawn },
  { name: 'Next camera: orbit, follow, chase, top, robot', key: 'c', shown: 'C', run: () => tools.nextCamera() },
  { name: 'Fit the robot, or the map', key: 'g', shown: 'G', run: press('fit') },
  { name: 'The whole map', key: 'Home', run: press('home') },
  { name: 'Plots', key: 'p', shown: 'P', run: togglePlots },
  { name: 'Plot position, speeds and slip', run: plotFirst },
  { name: 'Wire: the lines of the protocol', key: 'l', shown: 'L', drives: true, run: () => showTab('wire') },
  { name: 'Code: a program in Python', key: 'y', shown: 'Y', drives: true, run: () => showTab('code') },
  { name: 'Scenarios', key: 't', shown: 'T', drives: true, run: () => door.show() },
  { name: 'Change the map', key: 'm', shown: 'M', run: press('map') },
  { name: 'Record a log, or stop', run: press('record') },
  { name: 'Save the world to a file', run: press('save') },
  { name: 'Open a log, a robot, a world or a mesh', key: 'o', shown: 'O', run: press('open-log') },
  { name: 'Reset world', run: press('reset') },
  { name: 'Remove the chosen robot or object', run: removeChosen },
  { name: 'Menu of the chosen robot or object', key: 'u', shown: 'U', run: () => menu.openOfChosen() },
  { name: 'Pull the chosen robot or object by buttons', run: pullByButtons },
  { name: 'Put something in the middle of the view', drives: true, run: () => menu.openOfMiddle() },
  { name: 'Score board of a league: large or small', key: 'b', shown: 'B', run: () => board.toggle() },
  { name: 'Save the picture as PNG', run: press('screenshot') },
  { name: 'Share: a link, a picture of any size, a clip', run: press('share') },
  { name: 'Clear the paths', run: () => view.clearPaths() },
  { name: 'Light or dark', run: press('theme') },
  { name: 'Full screen', run: press('fullscreen') },
  { name: 'Picture quality: as this machine can', run: () => setQuality('auto') },
  ...QUALITIES.map((quality) => ({
    name: `Picture quality ${quality}: ${RUNGS[quality].what}`,
    run: () => setQuality(quality),
  })),
];
const possible = () => actions.filter(({ drives }) => !drives || !state.isWatched);
// Space is for time, not for buttons, while a robot is driven or the past is shown.
listenToKeys(possible, () => state.hasRobot || !state.isPresent);

find('commands').onclick = () => showCommands(possible());
find('help').onclick = () => showKeys(possible());
find('theme').onclick = () => setTheme(document.documentElement.dataset.theme !== 'dark');
find('map').onclick = () => offerMaps(state, live, transport);
find('screenshot').onclick = () => void sharing.savePicture(null);
find('share').onclick = () => sharing.open();
find('toggle-plots').onclick = togglePlots;
for (const button of document.querySelectorAll<HTMLElement>('[data-press]')) {
  button.onclick = press(button.dataset.press ?? '');
}
find('fullscreen').onclick = () =>
  void (document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen());
find('view').addEventListener('dblclick', focusView);

setInterval(() => drive.follow(), DRIVE_INTERVAL);
const paced = [
  every(panelInterval, showNumbers),
  every(
    () => Math.max(PLOT_INTERVAL, panelInterval()),
    () => plots.draw(),
  ),
];
view.onFrame = (now) => paced.forEach((run) => run(now));
