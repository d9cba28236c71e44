import { defineConfig } from 'vite';

// The server embeds what is built; `npm run dev` shows a running server's world through a proxy.
const server = 'http://127.0.0.1:8080';

export default defineConfig({
  build: { outDir: 'dist/page', emptyOutDir: true, chunkSizeWarningLimit: 1000 },
  // The interpreter of the page's programs is a module.
  worker: { format: 'es' },
  server: {
    proxy: {
      // The server lets only its own page in.
      '/scene.json': { target: server, changeOrigin: true, headers: { origin: server } },
      '/scenarios.json': { target: server, changeOrigin: true, headers: { origin: server } },
      '/scenario/': { target: server, changeOrigin: true, headers: { origin: server } },
      '/class/': { target: server, changeOrigin: true, headers: { origin: server } },
      '/objects.json': { target: server, changeOrigin: true, headers: { origin: server } },
      '/live': { target: server, ws: true, changeOrigin: true, headers: { origin: server } },
      '/wire': { target: server, ws: true, changeOrigin: true, headers: { origin: server } },
    },
  },
});
