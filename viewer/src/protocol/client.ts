/** A robot driven by hand: an ordinary client of the protocol, through the server's own port. */

import { refusal } from './refusal';
import type { RobotClass, Vector } from './scene';
import { loginLines } from './token';
import type { Connection, Transport } from './transport';

/** -1 to 1 of what the robot can do. */
export interface Twist {
  forward: number;
  right: number;
  clockwise: number;
  /** For robots in the air alone. */
  up: number;
}

export interface Spawn {
  robotClass: string;
  name: string;
  place: { start: string } | { location: Vector; yaw: number };
  /** Its team in a league. */
  team: string | null;
}

/** Returns the line that spawns a robot. */
export function initLine({ robotClass, name, place, team }: Spawn): string {
  const where =
    'start' in place ? `{Start ${place.start}}` : `{Location ${place.location.join(',')}} {Rotation 0,0,${place.yaw}}`;
  const ofTeam = team === null ? '' : ` {Team ${team}}`;
  return `INIT {ClassName USARBot.${robotClass}} {Name ${name}} ${where}${ofTeam}`;
}

/** Least time between two DRIVE lines, ms. */
const INTERVAL = 50;

export class Client {
  /** Hear each line that comes. */
  readonly heard = new Set<(line: string) => void>();
  private readonly connection: Connection;
  private isEnded = false;
  private readonly decoder = new TextDecoder();
  private text = '';
  private isGreeted = false;
  private sent = '';
  private next = '';
  /** The newest line for each joint and gripper, by its name. */
  private readonly settings = new Map<string, string>();
  private timer: number | null = null;

  constructor(
    readonly spawn: Spawn,
    readonly robot: RobotClass,
    private readonly ended: (what: string) => void,
    transport: Transport,
  ) {
    this.connection = transport.open('wire', {
      opened: () => {
        loginLines().forEach((line) => this.send(line));
      },
      received: (data) => {
        this.text += typeof data === 'string' ? data : this.decoder.decode(data, { stream: true });
        const lines = this.text.split('\n');
        this.text = lines.pop() ?? '';
        for (const line of lines) this.receive(line.trimEnd());
      },
      closed: (reason) => {
        if (this.timer !== null) clearTimeout(this.timer);
        if (!this.isEnded) ended(`has left: ${reason || 'its connection ended'}`);
      },
    });
  }

  /** True if nothing waits to be sent. */
  get isSent(): boolean {
    return this.next === this.sent && this.settings.size === 0;
  }

  /** Drives; of commands that come faster than lines are sent only the last one counts. */
  drive(twist: Twist): void {
    this.next = this.command(twist);
    if (this.timer === null) this.sendNext();
  }

  /** Moves a joint; of several targets that come faster than lines are sent only the last one counts. */
  setJoint(name: string, target: number): void {
    this.set(`SET {Type Joint} {Name ${name}} {Opcode Angle} {Params ${target.toFixed(4)}}`, `joint ${name}`);
  }

  /** Opens or closes a gripper. */
  setGripper(name: string, opcode: 'Open' | 'Close'): void {
    this.set(`SET {Type Gripper} {Name ${name}} {Opcode ${opcode}}`, `gripper ${name}`);
  }

  /** Ends the connection; the robot leaves with it. */
  end(): void {
    this.isEnded = true;
    this.connection.close();
  }

  private receive(line: string): void {
    this.heard.forEach((hear) => hear(line));
    if (!this.isGreeted && line.startsWith('NFO {Gametype')) {
      this.isGreeted = true;
      this.init();
      this.sendNext();
    }
    const [, error] = /^NFO \{Error (.*)\}$/.exec(line) ?? [];
    const reason = error === undefined ? null : refusal(error);
    if (reason !== null) this.ended(`was refused: ${reason}`);
  }

  private init(): void {
    this.send('REPORT {Errors true}');
    this.send(initLine(this.spawn));
  }

  private set(line: string, key: string): void {
    this.settings.set(key, line);
    if (this.timer === null) this.sendNext();
  }

  private sendNext(): void {
    this.timer = null;
    if (this.isGreeted && (this.next !== this.sent || this.settings.size > 0)) {
      if (this.next !== this.sent) this.send(this.next);
      this.sent = this.next;
      this.settings.forEach((line) => this.send(line));
      this.settings.clear();
      this.timer = window.setTimeout(() => this.sendNext(), INTERVAL);
    }
  }

  /** Sends a line; it is lost while there is no connection. */
  send(line: string): void {
    if (this.connection.isOpen) this.connection.send(`${line}\r\n`);
  }

  /** Writes a DRIVE line in percent of the limits, so the unit of wheel speeds does not matter. */
  private command({ forward, right, clockwise, up }: Twist): string {
    const percent = (part: number) => (100 * Math.max(-1, Math.min(1, part))).toFixed(1);
    const { steering, max_steer } = this.robot;
    if (steering === 'Aerial') {
      return `DRIVE {Normalized true} {LinearVelocity ${percent(forward)}} {LateralVelocity ${percent(right)}} {AltitudeVelocity ${percent(up)}} {RotationalVelocity ${percent(clockwise)}}`;
    }
    if (steering === 'AckermanSteered') {
      // The share of the steering does not follow the speed: a car steers as far as one turns its wheel.
      const [front, rear] = [Math.sign(clockwise) * max_steer[0], -Math.sign(clockwise) * max_steer[1]];
      const [ahead, aside] = [percent(forward), [front, rear].map((angle) => angle.toFixed(3))];
      return `DRIVE {Normalized true} {Speed ${ahead}} {FrontSteer ${aside[0]}} {RearSteer ${aside[1]}}`;
    }
    if (steering === 'OmniDrive') {
      return `DRIVE {Normalized true} {LinearVelocity ${percent(forward)}} {LateralVelocity ${percent(right)}} {RotationalVelocity ${percent(clockwise)}}`;
    }
    const most = Math.max(1, Math.abs(forward) + Math.abs(clockwise));
    return `DRIVE {Normalized true} {Left ${percent((forward + clockwise) / most)}} {Right ${percent((forward - clockwise) / most)}}`;
  }
}
