/** Transport over HTTP and WebSockets, to the server that the page comes from. */

import { readPast } from './frame';
import type { RobotClass, ScenarioCard, Scene, Spawned } from './scene';
import { fetchWithToken } from './token';
import type { Opened, Transport } from './transport';

export const network: Transport = {
  scene: async () => (await json('scene.json')) as Scene,
  robotClass: async (name) => (await json(`class/${encodeURIComponent(name)}`)) as RobotClass,
  objects: async () => (await json('objects.json')) as Spawned[],
  mapPicture: async (map) => (await fetchWithToken(`map/${encodeURIComponent(map)}/picture.png`)).blob(),
  past: async () => readPast(await (await fetchWithToken('past')).arrayBuffer()),
  sceneOfLog: async (world) => (await json('scene.json', { method: 'POST', body: world })) as Scene,
  scenarios: async () => (await json('scenarios.json')) as ScenarioCard[],
  async demo(scenario) {
    const log = await fetchWithToken(`scenario/${encodeURIComponent(scenario)}/demo.mcap`);
    return new File([await log.blob()], `${scenario}.mcap`);
  },
  async openFiles(files, chosen) {
    const form = new FormData();
    files.forEach((file, path) => form.append(path, file));
    const query = chosen === null ? '' : `?file=${encodeURIComponent(chosen)}`;
    return (await json(`open${query}`, { method: 'POST', body: form })) as Opened;
  },
  open(path, { opened, received, closed }) {
    const url = new URL(path, location.href);
    url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
    const socket = new WebSocket(url.href);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => opened();
    socket.onmessage = ({ data }: MessageEvent<ArrayBuffer | string>) => received(data);
    socket.onclose = ({ reason }) => closed(reason);
    return {
      get isOpen() {
        return socket.readyState === WebSocket.OPEN;
      },
      send: (text) => socket.send(text),
      close: () => socket.close(),
    };
  },
};

async function json(name: string, init: RequestInit = { cache: 'no-store' }): Promise<unknown> {
  return (await fetchWithToken(name, init)).json();
}
