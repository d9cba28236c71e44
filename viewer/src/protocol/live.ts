/** The connection that shows the world and controls its time, its start and its log. It comes back by itself. */

import { type Frame, type Past, type Picture, type Scan, readMessage } from './frame';
import { ClassQuestions } from './classes';
import { FitQuestions } from './fit';
import type { Control, Fit, FitAnswer, Message, Reading, Request, Status, WireLine } from './live.gen';
import { ObjectQuestions } from './objects';
import type { RobotClass, Scene, Spawned } from './scene';
import { Refused, token } from './token';
import type { Connection, Transport } from './transport';

export type { Control, League, Status, WireLine } from './live.gen';

/** Receiver of the server's messages. */
export interface Listener {
  scene(scene: Scene): void;
  /** The scene has another class of robots. */
  classCame(): void;
  /** Takes the objects that the map does not have. */
  objects(objects: Spawned[]): void;
  frame(frame: Frame, bytes: ArrayBuffer): void;
  /** Takes the run before the connection began. */
  past(past: Past): void;
  scan(scan: Scan): void;
  picture(picture: Picture): void;
  status(status: Status): void;
  line(line: WireLine): void;
  reading(reading: Reading): void;
  said(text: string): void;
  /** Takes the answer to a question where a robot could stand. */
  fit(answer: FitAnswer): void;
  /** The connection is lost. */
  lost(): void;
  /** The server asks for a token, or for another one. */
  refused(hadToken: boolean): void;
}

/** Pause between two attempts, ms. */
const RETRY = 1000;
/** Silence after which the connection counts as lost, ms. Frames come 30 times a second. */
const SILENCE = 5000;

export class Live {
  private connection: Connection | null = null;
  private wire = false;
  private robots: number[] = [];
  private cameras: number[] = [];
  /** The last status of this connection. */
  private status: Status | null = null;
  private isSceneStale = false;
  /** True if this connection has asked for the run before it. */
  private isPastAsked = false;
  private heard = 0;
  /** Numbers that the server is to send back. */
  private readonly echoes = new Map<number, () => void>();
  private sentEchoes = 0;
  /** Name that the server gives this page. */
  private you = '';
  /** Reason why this page may not control the world. */
  refused: string | null = null;

  private readonly fits = new FitQuestions(
    (fit) => this.send({ fit }),
    (answer) => this.listener.fit(answer),
  );
  private readonly classes = new ClassQuestions(
    () => this.listener.classCame(),
    (name) => this.transport.robotClass(name),
  );
  private readonly objects = new ObjectQuestions(
    (objects) => this.listener.objects(objects),
    () => this.connection?.close(),
    () => this.transport.objects(),
  );

  constructor(
    private readonly transport: Transport,
    private readonly listener: Listener,
  ) {
    void this.connect();
    setInterval(() => {
      if (this.connection?.isOpen && performance.now() - this.heard > SILENCE) {
        this.connection.close();
        this.lose(this.connection);
      }
    }, 1000);
  }

  control(control: Control): void {
    this.send(control);
  }

  /** Asks whether a robot could stand somewhere. */
  askFit(fit: Fit): void {
    this.fits.ask(fit);
  }

  /** Waits until the server has read what this page has sent, or is lost. */
  echo(): Promise<void> {
    if (!this.connection?.isOpen) return Promise.resolve();
    const number = ++this.sentEchoes;
    this.send({ echo: number });
    return new Promise((resolve) => this.echoes.set(number, resolve));
  }

  /** Returns a class of robots; null if the server has none of that name, or is lost. */
  classOf(name: string): Promise<RobotClass | null> {
    return this.classes.want(name);
  }

  /** Asks for every line of the wire, or for none. */
  listenToWire(wanted: boolean): void {
    this.wire = wanted;
    this.listen();
  }

  /** Asks for the readings of robots. */
  listenToRobots(robots: number[]): void {
    if (String(robots) === String(this.robots)) return;
    this.robots = robots;
    this.listen();
  }

  /** The robots whose cameras' pictures are to be sent; each picture is work for the server. */
  listenToCameras(robots: number[]): void {
    if (String(robots) === String(this.cameras)) return;
    this.cameras = robots;
    this.listen();
  }

  private listen(): void {
    this.send({ wire: this.wire, robots: this.robots, cameras: this.cameras });
  }

  private send(request: Request): void {
    if (this.connection?.isOpen) this.connection.send(JSON.stringify(request));
  }

  /** Connects; to be called again with another token. */
  async connect(): Promise<void> {
    try {
      // Anew each time: it may be another server now.
      const scene = await this.transport.scene();
      this.classes.restart(scene);
      this.listener.scene(scene);
    } catch (error) {
      // Whoever has another token connects again.
      if (error instanceof Refused) this.listener.refused(token() !== null);
      else this.retry();
      return;
    }
    [this.status, this.isSceneStale, this.isPastAsked] = [null, false, false];
    this.heard = performance.now();
    this.fits.restart();
    this.objects.restart();
    const connection = this.transport.open('live', {
      opened: () => {
        const own = token();
        if (own !== null) this.send({ token: own });
        this.listen();
      },
      received: (data) => this.take(data),
      closed: () => this.lose(connection),
    });
    this.connection = connection;
  }

  private lose(connection: Connection): void {
    if (this.connection === connection) {
      this.connection = null;
      this.echoes.forEach((resolve) => resolve());
      this.echoes.clear();
      this.listener.lost();
      this.retry();
    }
  }

  private retry(): void {
    setTimeout(() => void this.connect(), RETRY);
  }

  /** Marks this page's own actions. */
  private addressed(text: string): string {
    return this.you && text.startsWith(`${this.you} `) ? `You ${text.slice(this.you.length + 1)}` : text;
  }

  private takeStatus(status: Status): void {
    const before = this.status;
    this.status = status;
    if (before && status.scene !== before.scene) void this.fetchAnotherScene();
    if (this.isSceneStale) return;
    this.listener.status(status);
    for (const robot of status.robots) void this.classes.want(robot.class);
    // A world that began anew gives the same numbers to other objects.
    if (status.resets !== before?.resets) this.objects.restart();
    if (status.resets !== before?.resets || status.objects !== before.objects) this.objects.ask();
  }

  private takeFrame(frame: Frame, bytes: ArrayBuffer): void {
    this.listener.frame(frame, bytes);
    // It is known by now which world it is, and from when on.
    if (!this.status || this.isPastAsked) return;
    this.isPastAsked = true;
    void this.fetchPast();
  }

  private async fetchPast(): Promise<void> {
    const { connection } = this;
    try {
      const past = await this.transport.past();
      if (connection !== this.connection || this.isSceneStale) return;
      for (const robot of past.robots) void this.classes.want(robot.class);
      this.listener.past(past);
    } catch {
      // The page has its own past from here on.
    }
  }

  /** The server shows another map: nothing of the new one is shown before its scene is there. */
  private async fetchAnotherScene(): Promise<void> {
    this.isSceneStale = true;
    this.objects.restart();
    try {
      const scene = await this.transport.scene();
      this.classes.keep(scene);
      this.listener.scene(scene);
      this.isSceneStale = false;
      this.objects.ask();
    } catch {
      this.connection?.close();
    }
  }

  private takeEcho(number: number): void {
    this.echoes.get(number)?.();
    this.echoes.delete(number);
  }

  private take(data: ArrayBuffer | string): void {
    this.heard = performance.now();
    if (typeof data !== 'string') {
      const message = data.byteLength > 0 ? readMessage(data) : null;
      if (this.isSceneStale) return;
      if (message && 'frame' in message) this.takeFrame(message.frame, data);
      else if (message && 'scan' in message) this.listener.scan(message.scan);
      else if (message) this.listener.picture(message.picture);
      return;
    }
    const message = JSON.parse(data) as Message;
    if ('you' in message) [this.you, this.refused] = [message.you, message.refused];
    else if ('status' in message) this.takeStatus(message.status);
    else if ('line' in message) this.listener.line(message.line);
    else if ('reading' in message) this.listener.reading(message.reading);
    else if ('fit' in message) this.fits.take(message.fit);
    else if ('echo' in message) this.takeEcho(message.echo);
    else if ('said' in message) this.listener.said(this.addressed(message.said));
    else this.listener.said(`${message.missed} lines, readings and scans came too fast to be shown`);
  }
}
