import { defineConfig, type Plugin } from 'vite';
import { fakeRun } from './dev/fake_run';
import { handleApi } from './dev/fake_server';

/** `npm run dev` shows a made-up run, so that the page can be worked on without a simulation. */
function fakeApi(): Plugin {
  return {
    name: 'brim-fake-api',
    configureServer(server) {
      const run = fakeRun();
      server.middlewares.use((request, response, next) => {
        if (!handleApi(run, request, response)) next();
      });
    },
  };
}

export default defineConfig({
  base: './',
  build: { outDir: 'dist', target: 'es2022', chunkSizeWarningLimit: 1200, assetsInlineLimit: 0 },
  plugins: [fakeApi()],
});
