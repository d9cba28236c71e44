/** Way between the page and a server. `network.ts` has the one over HTTP and WebSockets. */

import type { RobotClass, Scene, Spawned } from './scene';

export interface Transport {
  /** Returns the scene. Fails with `Refused` if the server wants a token, or another one. */
  scene(): Promise<Scene>;
  robotClass(name: string): Promise<RobotClass>;
  /** Returns the objects that the map does not have. */
  objects(): Promise<Spawned[]>;
  /** Returns the scene that the server makes of a log's world, in JSON. */
  sceneOfLog(world: string): Promise<Scene>;
  /** Opens a connection: `live` shows and controls the world, `wire` is the protocol of controllers. */
  open(path: 'live' | 'wire', events: Events): Connection;
}

export interface Connection {
  readonly isOpen: boolean;
  send(text: string): void;
  close(): void;
}

/** Receiver of a connection's events. */
export interface Events {
  opened(): void;
  received(data: ArrayBuffer | string): void;
  /** Takes the end of the connection, whoever closed it, with the server's reason if there is one. */
  closed(reason: string): void;
}
