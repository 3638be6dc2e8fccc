// What a frame of a run costs the page: node measure.mjs RUN [WIDTHxHEIGHT], RUN being a run folder.
// Prints the scripts' time (decode, show, draw), draw calls and triangles per frame, by the page's own clock, in Chromium
// without a window. Drawing itself is done in software there, so its time says nothing of a graphics card and is left out.
import { spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

const [run, size = '1280x720'] = process.argv.slice(2);
const [width, height] = size.split('x').map(Number);
const builds = ['release', 'demo'].map((b) => fileURLToPath(new URL(`../build/${b}/brim`, import.meta.url)));
const brim = process.env.BRIM ?? builds.find(existsSync);
if (!brim) throw new Error('there is no program yet: ./dev build makes it, or BRIM names one');
const server = spawn(brim, ['view', run, '--port', '0'], { stdio: ['ignore', 'pipe', 'inherit'] });
const url = await new Promise((done) => {
  let text = '';
  server.stdout.on('data', (data) => {
    text += data;
    const found = /http:\S+/.exec(text);
    if (found) done(found[0]);
  });
});
const browser = await chromium.launch({
  executablePath: process.env.BRIM_CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
const page = await browser.newPage({ viewport: { width, height } });
page.setDefaultTimeout(300_000);
await page.goto(url, { waitUntil: 'commit' });
await page.waitForFunction(() => Boolean(window.brim));
await page.evaluate(() => window.brim.ready);
const costs = await page.evaluate(async () => {
  const { frames } = window.brim.app.player;
  window.brim.app.player.playing = false;
  await window.brim.measure([0, Math.floor(frames / 2)]); // buffers made, shaders compiled
  return window.brim.measure(Array.from({ length: frames }, (_, f) => f));
});
await browser.close();
server.kill();
const line = (name, values, digits) => {
  const sorted = [...values].sort((a, b) => a - b);
  const at = (q) => sorted[Math.min(sorted.length - 1, Math.floor(q * sorted.length))].toFixed(digits);
  console.log(
    `${name.padEnd(12)} least ${sorted[0].toFixed(digits).padStart(10)}   median ${at(0.5).padStart(10)}   19 of 20 below ${at(0.95).padStart(10)}   worst ${at(1).padStart(10)}`,
  );
};
console.log(`${run}: ${costs.length} frames at ${width}x${height}`);
for (const part of ['decode', 'show', 'draw'])
  line(
    `${part} [ms]`,
    costs.map((c) => c[part]),
    2,
  );
line(
  'all [ms]',
  costs.map((c) => c.decode + c.show + c.draw),
  2,
);
line(
  'draw calls',
  costs.map((c) => c.calls),
  0,
);
line(
  'triangles',
  costs.map((c) => c.triangles),
  0,
);
line(
  'kB',
  costs.map((c) => c.bytes / 1000),
  0,
);
