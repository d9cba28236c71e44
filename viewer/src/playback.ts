/** Which moment is shown: the server's present, the last minute, or one of a log. */

import { History } from './history';
import { LogFile, Player } from './log';
import type { Frame, Scan } from './protocol/frame';
import type { Status, WireLine } from './protocol/live';
import type { Scene } from './protocol/scene';

export type Mode = 'live' | 'past' | 'log';

/** What the page does with what is shown, wherever it comes from. */
export interface Screen {
  scene(scene: Scene): void;
  frame(frame: Frame): void;
  scan(scan: Scan): void;
  status(status: Status): void;
  line(line: WireLine): void;
  /** Time has changed without passing: what was drawn of a while is of another time. */
  jumped(): void;
  /** The mode, or how a log plays, is another. */
  changed(): void;
  said(text: string): void;
}

/** What stays of a status while a log is shown. */
const OF_LOG = {
  real_time_factor: 0,
  resets: 0,
  scene: 0,
  viewers: 0,
  unsettled_steps: 0,
  recording: null,
  clients: [],
};

export class Playback {
  mode: Mode = 'live';
  /** Seconds of a log a second. */
  rate = 1;
  private readonly history = new History();
  private player: Player | null = null;
  private name = '';
  /** The server's, also while something else is shown. */
  private live: { scene: Scene | null; status: Status | null; frame: Frame | null } = {
    scene: null,
    status: null,
    frame: null,
  };

  constructor(private readonly screen: Screen) {}

  takeScene(scene: Scene): void {
    this.live = { scene, status: null, frame: null };
    this.history.clear();
    if (this.mode === 'past') this.mode = 'live';
    if (this.mode !== 'log') this.screen.scene(scene);
  }

  takeFrame(frame: Frame, bytes: ArrayBuffer): void {
    this.live.frame = frame;
    this.history.add(frame.time, bytes);
    if (this.mode === 'live') this.screen.frame(frame);
  }

  takeScan(scan: Scan): void {
    if (this.mode === 'live') this.screen.scan(scan);
  }

  takeStatus(status: Status): void {
    this.live.status = status;
    if (this.mode !== 'log') this.screen.status(status);
  }

  takeLine(line: WireLine): void {
    if (this.mode === 'live') this.screen.line(line);
  }

  /** First and last time that can be shown, s. */
  get range(): [number, number] {
    return this.player ? [this.player.log.start, this.player.log.end] : this.history.range;
  }

  /** Whether what is shown stands still. */
  get isPaused(): boolean {
    return this.player ? !this.player.isPlaying : (this.live.status?.paused ?? false);
  }

  /** The file that is shown. */
  get logName(): string | null {
    return this.player ? this.name : null;
  }

  /** Of the last minute about so many frames; of a log none, as it would have to be read. */
  past(count: number): Frame[] {
    return this.player ? [] : this.history.sample(count);
  }

  goTo(time: number): void {
    if (this.player) return void this.player.seek(time);
    const frame = this.history.at(time);
    if (!frame) return;
    this.mode = 'past';
    this.screen.frame(frame);
    this.screen.changed();
  }

  goLive(): void {
    const wasLog = this.mode === 'log';
    this.player?.close();
    [this.player, this.mode] = [null, 'live'];
    const { scene, status, frame } = this.live;
    if (wasLog && scene) this.screen.scene(scene);
    if (status) this.screen.status(status);
    this.screen.jumped();
    if (frame) this.screen.frame(frame);
    this.screen.changed();
  }

  /** Plays a log in place of the server's world, which goes on unseen. */
  async open(file: File): Promise<void> {
    try {
      const log = await LogFile.open(file);
      this.player?.close();
      this.player = new Player(log, {
        frame: (frame) => this.screen.frame(frame),
        status: (robots) => this.showStatus(robots),
        scan: (scan) => this.screen.scan(scan),
        line: (line) => this.screen.line(line),
        jumped: () => this.screen.jumped(),
        ended: () => this.screen.changed(),
        failed: (reason) => this.screen.said(`${file.name}: ${reason}`),
      });
      this.player.wantLines = true;
      [this.name, this.mode] = [file.name, 'log'];
      this.screen.scene({ ...log.scene, port: this.live.scene?.port ?? 0, maps: this.live.scene?.maps ?? [] });
      this.showStatus([]);
      if (log.damage) this.screen.said(`${file.name}: ${log.damage}: it is shown up to there`);
      this.player.play(this.rate);
      this.screen.changed();
    } catch (reason) {
      this.screen.said(`${file.name}: ${reason instanceof Error ? reason.message : String(reason)}`);
    }
  }

  /** Stops or resumes a log. */
  playOrPause(): void {
    if (this.player?.isPlaying) this.player.pause();
    else this.player?.play(this.rate);
    this.screen.changed();
  }

  step(seconds: number): void {
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
