/** Way between the page and a server. `network.ts` has the one over HTTP and WebSockets. */

import type { Past } from './frame';
import type { RobotClass, ScenarioCard, Scene, Spawned } from './scene';

export interface Transport {
  /** Returns the scene. Fails with `Refused` if the server wants a token, or another one. */
  scene(): Promise<Scene>;
  robotClass(name: string): Promise<RobotClass>;
  /** Returns the objects that the map does not have. */
  objects(): Promise<Spawned[]>;
  /** Returns the picture of a map that the server offers. */
  mapPicture(map: string): Promise<Blob>;
  /** Returns frames of the run so far. */
  past(): Promise<Past>;
  /** Returns the scene that the server makes of a log's world, in JSON. */
  sceneOfLog(world: string): Promise<Scene>;
  /** Returns the scenarios that the server offers. */
  scenarios(): Promise<ScenarioCard[]>;
  /** Returns the log of a scenario's demo. The server plays it when somebody first asks, which takes a second or two. */
  demo(scenario: string): Promise<File>;
  /** Sends files of other programs, by their paths, to the server, which opens the chosen one, or the only one that it could be. */
  openFiles(files: ReadonlyMap<string, File>, chosen: string | null): Promise<Opened>;
  /** Opens a connection: `live` shows and controls the world, `wire` is the protocol of controllers. */
  open(path: 'live' | 'wire', events: Events): Connection;
}

/** A class or a map that the server made of files, or a question which file is meant. */
export type Opened =
  (({ robot: string } | { map: string }) & { verdict: string[]; notes: string[] }) | { choices: string[] };

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
