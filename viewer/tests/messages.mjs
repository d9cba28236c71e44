// Binary messages as the server sends them, written by a writer made of live.proto.

import { join } from 'node:path';
import { compile } from 'pbf/compile';
import { PbfWriter } from 'pbf';
import schema from 'resolve-protobuf-schema';
import { root } from './server.mjs';

const { writeMessage } = compile(schema.sync(join(root, 'crates/page-protocol/proto/live.proto')));

/** Returns a message: `{frame}`, `{scan}` or `{picture}`. */
export function messageBytes(message) {
  const pbf = new PbfWriter();
  writeMessage(message, pbf);
  return Uint8Array.from(pbf.finish()).buffer;
}

/** Returns a frame without robots. Objects are `{number, pose}`. */
export function frameBytes(time, objects = []) {
  const placed = objects.map(({ number, pose }) => ({ object: number, pose }));
  return messageBytes({ frame: { time, robots: [], objects: placed } });
}

/** What a page has of its browser: an address, and storage for a token, which is empty. */
export function standInForBrowser() {
  globalThis.location = { href: 'http://127.0.0.1:1/', hash: '' };
  globalThis.sessionStorage = { getItem: () => null };
}

/** Lets promises run until a condition holds, and a few turns more. Takes no timer, which a test may have replaced. */
export async function settled(condition) {
  const turn = () => new Promise(setImmediate);
  for (const end = Date.now() + 10_000; !condition() && Date.now() < end;) await turn();
  for (let more = 0; more < 5; more++) await turn();
}
