/** Lines that somebody sends by hand: a client of the protocol that has no robot until its lines ask for one. */

import { loginLines } from './token';
import type { Connection, Transport } from './transport';

export class Hand {
  private connection: Connection | null = null;
  /** Lines that wait for the connection. */
  private waiting: string[] = [];

  constructor(
    private readonly transport: Transport,
    private readonly ended: (why: string) => void,
    /** Lines that it begins with. */
    private readonly first: readonly string[] = [],
  ) {}

  /** Sends a line, and connects before the first. */
  say(line: string): void {
    this.waiting.push(line);
    if (this.connection?.isOpen) return this.send();
    this.connection ??= this.transport.open('wire', {
      opened: () => {
        // Without reports a wrong line would be answered by nothing.
        this.waiting.unshift(...loginLines(), 'REPORT {Errors true}', ...this.first);
        this.send();
      },
      // The list of lines shows what comes.
      received: () => {},
      closed: (reason) => {
        this.connection = null;
        this.waiting = [];
        this.ended(reason || 'its connection ended');
      },
    });
  }

  private send(): void {
    this.waiting.forEach((line) => this.connection?.send(`${line}\r\n`));
    this.waiting = [];
  }
}
