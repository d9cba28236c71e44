/** Choice of the shown moment: the server's present, the run so far, or a log. */

import { History } from './history';
import { LogFile, Player } from './log';
import { type Late, type Mark, Marks } from './marks';
import type { Frame, Past, Picture, Scan } from './protocol/frame';
import type { Status, WireLine } from './protocol/live';
import type { Scene, Solid, Spawned } from './protocol/scene';
import type { Reading } from './protocol/sensors';

export type Mode = 'live' | 'past' | 'log';

/** Class and name of a robot. */
export type Known = Pick<Status['robots'][number], 'class' | 'name'>;

/** Receiver of what is shown, from any source. */
export interface Screen {
  scene(scene: Scene): void;
  /** Takes the objects that the map does not have, by their numbers: those of the frames that follow, and maybe more. */
  objects(objects: ReadonlyMap<number, Solid>): void;
  /** Takes the robots that are or were in the world, by their numbers. */
  robots(robots: ReadonlyMap<number, Known>): void;
  frame(frame: Frame): void;
  /** Takes the newest frame of the server's world, also while its past is shown. */
  present(frame: Frame): void;
  /** More of a log's frames are known, or another world began: plots are filled anew. */
  refilled(): void;
  scan(scan: Scan): void;
  /** Takes what a camera saw in the present: neither the past nor a log has pictures. */
  picture(picture: Picture): void;
  status(status: Status): void;
  line(line: WireLine): void;
  reading(reading: Reading): void;
  /** Time has changed without passing: what was drawn of a while is of another time. */
  jumped(): void;
  /** The mode, or how a log plays, is another. */
  changed(): void;
  said(text: string): void;
  /** The moment that is shown, s. */
  shownTime(): number;
}

/** Interval between two frames of the past, ms. */
const INTERVAL = 33;
/** Moments of a log that plots and marks are made from: so many a second, and at most. */
const SAMPLES = { perSecond: 20, most: 600 };
/** A reset comes so long before the first frame of its world at most, s. */
const BEFORE = 0.5;
/** Samples between two updates of plots. */
const SAMPLES_SHOWN = 100;

/** Status of a log, without robots. */
const OF_LOG = {
  real_time_factor: 0,
  resets: 0,
  saves: 0,
  scene: 0,
  objects: 0,
  viewers: 0,
  unsettled_steps: 0,
  recording: null,
  league: null,
  clients: [],
};

export class Playback {
  mode: Mode = 'live';
  /** Seconds of a log, or of the past, a second. */
  rate = 1;
  private readonly history = new History();
  private player: Player | null = null;
  /** Number of times that a log was opened, or left. */
  private opening = 0;
  private name = '';
  private readonly presentMarks = new Marks();
  private readonly logMarks = new Marks();
  /** Frames from all of a log. */
  private samples: Frame[] = [];
  /** Last moment of the past that was played, s, and when, ms; null while it stands. */
  private playing: { wall: number; time: number } | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;
  /** The server's, also while something else is shown. */
  private live: { scene: Scene | null; status: Status | null; frame: Frame | null } = {
    scene: null,
    status: null,
    frame: null,
  };
  /** Spawned objects of the server's world by number. Removed ones are kept for the past. */
  private objects = new Map<number, Solid>();
  /** Robots of the server's world by number, also those that have left. */
  private robots = new Map<number, Known>();

  constructor(
    /** Returns the scene of a log's world, in JSON. */
    private readonly askScene: (world: string) => Promise<Scene>,
    private readonly screen: Screen,
  ) {}

  takeScene(scene: Scene): void {
    this.live = { scene, status: null, frame: null };
    this.objects = new Map();
    this.robots = new Map();
    this.history.clear();
    this.presentMarks.clear();
    if (this.mode === 'log') return;
    this.leavePast();
    this.screen.scene(scene);
    this.showKnown();
    this.screen.changed();
    this.screen.refilled();
  }

  /** Takes the objects that the server's world has now beside the map's. */
  takeObjects(objects: Spawned[]): void {
    // A number is always of the same object, which then is not drawn anew.
    for (const object of objects) if (!this.objects.has(object.number)) this.objects.set(object.number, object);
    if (this.mode !== 'log') this.screen.objects(this.objects);
  }

  /** Takes the run before the page was opened, if it is of the world that is shown. */
  takePast({ resets, frames, robots, objects }: Past): void {
    if (this.live.status?.resets !== resets) return;
    const [opened] = this.history.range;
    this.history.prepend(frames);
    this.presentMarks.takePast(robots, opened);
    for (const { robot, ...known } of robots) if (!this.robots.has(robot)) this.robots.set(robot, known);
    this.takeObjects(objects);
    if (this.mode !== 'log') this.screen.refilled();
  }

  takeFrame(frame: Frame, bytes: ArrayBuffer): void {
    const isAnother = this.live.frame !== null && frame.time < this.live.frame.time;
    this.live.frame = frame;
    this.history.add(frame.time, bytes);
    if (this.mode === 'log') return;
    // The past of a world that began anew is gone.
    if (isAnother && this.mode === 'past') this.goLive();
    if (isAnother) this.screen.refilled();
    this.screen.present(frame);
    if (this.mode === 'live') this.screen.frame(frame);
  }

  takeScan(scan: Scan): void {
    if (this.mode === 'live') this.screen.scan(scan);
  }

  takePicture(picture: Picture): void {
    if (this.mode === 'live') this.screen.picture(picture);
  }

  takeStatus(status: Status): void {
    if (this.live.status && this.live.status.resets !== status.resets) this.forgetWorld();
    this.live.status = status;
    // The first status may come before the first frame. It is what later ones are compared with.
    this.presentMarks.take(this.live.frame?.time ?? 0, status);
    this.presentMarks.takePace(this.live.frame?.time ?? 0, status);
    for (const robot of status.robots) this.robots.set(robot.id, robot);
    if (this.mode !== 'log') this.screen.status(status);
  }

  /** A fresh world gives the same numbers to other objects and robots. */
  private forgetWorld(): void {
    this.objects = new Map();
    this.robots = new Map();
    if (this.mode !== 'log') this.showKnown();
  }

  private showKnown(): void {
    this.screen.objects(this.objects);
    this.screen.robots(this.robots);
  }

  takeLine(line: WireLine): void {
    if (this.mode === 'live') this.screen.line(line);
  }

  takeReading(reading: Reading): void {
    if (this.mode === 'live') this.screen.reading(reading);
  }

  /** First and last time that can be shown, s. */
  get range(): [number, number] {
    return this.player ? [this.player.log.start, this.player.log.end] : this.history.range;
  }

  /** True if the shown moment stands still. */
  get isPaused(): boolean {
    if (this.player) return !this.player.isPlaying;
    return this.mode === 'past' ? this.playing === null : (this.live.status?.paused ?? false);
  }

  /** Events in the time that can be shown. */
  get marks(): Mark[] {
    const [first] = this.range;
    return (this.player ? this.logMarks : this.presentMarks).list.filter(({ time }) => time >= first - BEFORE);
  }

  /** Times in which the world was slower than it was asked to be. A log has none. */
  get late(): readonly Late[] {
    return this.player ? [] : this.presentMarks.late;
  }

  /** The file that is shown. */
  get logName(): string | null {
    return this.player ? this.name : null;
  }

  /** About so many frames of the run so far, or those that have been read of a log. */
  past(count: number): Frame[] {
    return this.player ? this.samples : this.history.sample(count);
  }

  goTo(time: number): void {
    if (this.player) return void this.player.seek(time);
    if (this.playing) this.playing = { wall: performance.now(), time };
    this.showPast(time);
  }

  /** Shows the frame before the shown one. A log has no frames: it goes back by the time between two. */
  goBack(): void {
    const shown = this.screen.shownTime();
    this.goTo(this.player ? shown - INTERVAL / 1000 : this.history.before(shown));
  }

  private showPast(time: number): void {
    const frame = this.history.at(time);
    if (!frame) return;
    const wasPast = this.mode === 'past';
    this.mode = 'past';
    this.screen.frame(frame);
    if (wasPast) return;
    this.rate = 1;
    this.screen.changed();
  }

  private leavePast(): void {
    if (this.mode === 'past') this.mode = 'live';
    this.playing = null;
    clearTimeout(this.timer);
  }

  /** Shows the next moment of the past until there is none. */
  private playPast(): void {
    if (!this.playing) return;
    const now = performance.now();
    const [first, last] = this.history.range;
    // What is older than a minute is forgotten while it is played.
    const time = Math.max(first, this.playing.time + (this.rate * (now - this.playing.wall)) / 1000);
    this.playing = { wall: now, time };
    this.showPast(time);
    if (time < last) this.timer = setTimeout(() => this.playPast(), INTERVAL);
    else this.pausePast();
  }

  private pausePast(): void {
    this.playing = null;
    clearTimeout(this.timer);
    this.screen.changed();
  }

  goLive(): void {
    this.opening++;
    const wasLog = this.mode === 'log';
    this.leavePast();
    this.player?.close();
    [this.player, this.mode, this.samples] = [null, 'live', []];
    const { scene, status, frame } = this.live;
    if (wasLog && scene) this.screen.scene(scene);
    if (wasLog) this.showKnown();
    if (status) this.screen.status(status);
    this.screen.jumped();
    if (frame) this.screen.frame(frame);
    this.screen.changed();
    if (wasLog) this.screen.refilled();
  }

  /** Plays a log in place of the server's world, which goes on unseen. */
  async open(file: File): Promise<void> {
    const turn = ++this.opening;
    try {
      const log = await LogFile.open(file, this.askScene);
      // Meanwhile somebody has opened another one, or returned to the present.
      if (turn !== this.opening) return;
      this.leavePast();
      this.player?.close();
      this.samples = [];
      this.logMarks.clear();
      this.player = new Player(log, {
        frame: (frame) => this.screen.frame(frame),
        objects: (objects) => this.screen.objects(objects),
        status: (robots) => this.showStatus(robots),
        scan: (scan) => this.screen.scan(scan),
        line: (line) => this.screen.line(line),
        reading: (reading) => this.screen.reading(reading),
        jumped: () => this.screen.jumped(),
        ended: () => this.screen.changed(),
        failed: (reason) => this.screen.said(`${file.name}: ${reason}`),
      });
      this.player.wantLines = true;
      [this.name, this.mode] = [file.name, 'log'];
      // What can be spawned and loaded is the server's.
      const { port = 0, maps = [], names = [] } = this.live.scene ?? {};
      this.screen.scene({ ...log.scene, port, maps, names });
      this.screen.objects(new Map());
      this.screen.robots(new Map());
      this.showStatus([]);
      if (log.damage) this.screen.said(`${file.name}: ${log.damage}: it is shown up to there`);
      this.rate = 1;
      this.player.play(this.rate);
      this.screen.changed();
      this.screen.refilled();
      void this.sample(this.player);
    } catch (reason) {
      this.screen.said(`${file.name}: ${reason instanceof Error ? reason.message : String(reason)}`);
    }
  }

  /** Reads moments from all of a log, one after the other, while it plays. */
  private async sample(player: Player): Promise<void> {
    const { start, end } = player.log;
    const count = Math.max(1, Math.min(SAMPLES.most, Math.ceil((end - start) * SAMPLES.perSecond)));
    try {
      for (let index = 0; index <= count; index++) {
        const time = start + ((end - start) * index) / count;
        const { frame, robots } = await player.log.robotsAt(time);
        if (this.player !== player) return;
        this.samples.push(frame);
        this.logMarks.take(time, { ...OF_LOG, robots });
        if (index % SAMPLES_SHOWN === 0 || index === count) this.screen.refilled();
      }
    } catch {
      // The player comes to the same place, and says what is wrong there.
    }
  }

  /** Stops or resumes a log, or the past. */
  playOrPause(): void {
    if (this.mode === 'past') return this.playing ? this.pausePast() : this.resumePast();
    if (this.player?.isPlaying) this.player.pause();
    else this.player?.play(this.rate);
    this.screen.changed();
  }

  private resumePast(): void {
    const [first, last] = this.history.range;
    const shown = this.screen.shownTime();
    this.playing = { wall: performance.now(), time: shown < last ? shown : first };
    this.playPast();
    this.screen.changed();
  }

  step(seconds: number): void {
    if (this.mode === 'past') {
      this.pausePast();
      return this.showPast(this.history.after(this.screen.shownTime()));
    }
    void this.player?.step(seconds);
    this.screen.changed();
  }

  setRate(rate: number): void {
    this.rate = rate;
    if (this.player?.isPlaying) this.player.play(rate);
    this.screen.changed();
  }

  private showStatus(robots: Status['robots']): void {
    this.screen.status({ ...OF_LOG, speed: this.rate, paused: false, robots });
  }
}
