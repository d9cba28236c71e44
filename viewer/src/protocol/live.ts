/** The connection that shows the world and controls its time, its start and its log. It comes back by itself. */

import { type Frame, type Scan, readMessage } from './frame';
import { type Scene, fetchScene } from './scene';

export interface Status {
  real_time_factor: number;
  speed: number;
  paused: boolean;
  resets: number;
  /** Steps of robots that ended before every contact did what it should. */
  unsettled_steps: number;
  recording: string | null;
  robots: { id: number; class: string; name: string; connection: number | null; battery: number | null }[];
  clients: { connection: number; peer: string; lines: number; dropped: number }[];
}

export interface WireLine {
  time: number;
  direction: 'in' | 'out';
  connection: number;
  robot: number | null;
  text: string;
}

export type Control = { pause: boolean } | { step: number } | { speed: number } | 'reset' | { record: boolean };

/** What the page does with what comes. */
export interface Listener {
  scene(scene: Scene): void;
  frame(frame: Frame): void;
  scan(scan: Scan): void;
  status(status: Status): void;
  line(line: WireLine): void;
  said(text: string): void;
  /** The connection is lost. */
  lost(): void;
}

/** Between two attempts, ms. */
const RETRY = 1000;
/** Nothing for so long means that the connection is dead, ms: frames come 30 times a second. */
const SILENCE = 5000;

export class Live {
  private socket: WebSocket | null = null;
  private wire = false;
  private heard = 0;

  constructor(private readonly listener: Listener) {
    void this.connect();
    setInterval(() => {
      if (this.socket?.readyState === WebSocket.OPEN && performance.now() - this.heard > SILENCE) {
        this.socket.close();
        this.lose(this.socket);
      }
    }, 1000);
  }

  control(control: Control): void {
    this.send(JSON.stringify(control));
  }

  /** Whether the lines of the wire are wanted. */
  listenToWire(wanted: boolean): void {
    this.wire = wanted;
    this.send(JSON.stringify({ wire: wanted }));
  }

  private send(text: string): void {
    if (this.socket?.readyState === WebSocket.OPEN) {
      this.socket.send(text);
    }
  }

  private async connect(): Promise<void> {
    try {
      // Anew each time: it may be another server now.
      this.listener.scene(await fetchScene());
    } catch {
      this.retry();
      return;
    }
    const socket = new WebSocket(socketUrl('live'));
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    this.heard = performance.now();
    socket.onopen = () => this.listenToWire(this.wire);
    socket.onmessage = (event: MessageEvent<ArrayBuffer | string>) => this.take(event.data);
    socket.onclose = () => this.lose(socket);
  }

  private lose(socket: WebSocket): void {
    if (this.socket === socket) {
      this.socket = null;
      this.listener.lost();
      this.retry();
    }
  }

  private retry(): void {
    setTimeout(() => void this.connect(), RETRY);
  }

  private take(data: ArrayBuffer | string): void {
    this.heard = performance.now();
    if (typeof data !== 'string') {
      const message = data.byteLength > 0 ? readMessage(data) : null;
      if (message && 'frame' in message) this.listener.frame(message.frame);
      else if (message) this.listener.scan(message.scan);
      return;
    }
    const message = JSON.parse(data) as { status?: Status; line?: WireLine; said?: string; missed?: number };
    if (message.status) this.listener.status(message.status);
    if (message.line) this.listener.line(message.line);
    if (message.said !== undefined) this.listener.said(message.said);
    if (message.missed !== undefined) this.listener.said(`${message.missed} lines and scans came too fast to be shown`);
  }
}

export function socketUrl(path: string): string {
  const url = new URL(path, location.href);
  url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
  return url.href;
}
