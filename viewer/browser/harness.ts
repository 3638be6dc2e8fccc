/** Opens the built page in Chromium against a made-up run. */
import { existsSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { chromium, type Browser, type Page } from 'playwright-core';
import { fakeRun, type FakeRun } from '../dev/fake_run';
import { startFakeServer, type FakeServer } from '../dev/fake_server';

export const chromiumPath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(
  existsSync,
);
export const page = fileURLToPath(new URL('../dist', import.meta.url));

export const launch = (): Promise<Browser> =>
  chromium.launch({
    executablePath: chromiumPath!,
    args: [
      '--no-sandbox',
      '--use-gl=angle',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
      '--no-first-run',
      '--disable-quic',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
    ],
  });

export interface Opened {
  page: Page;
  run: FakeRun;
  server: FakeServer;
  problems: string[]; // errors of the page's scripts
  requests: string[];
}

/** A small window keeps drawing in software quick. */
export async function open(
  browser: Browser,
  run = fakeRun(),
  size = { width: 1000, height: 560 },
): Promise<Opened> {
  const server = await startFakeServer(run, page);
  const tab = await browser.newPage({ viewport: size });
  const problems: string[] = [];
  const requests: string[] = [];
  tab.on('pageerror', (error) => problems.push(error.message));
  tab.on('request', (request) => requests.push(request.url()));
  tab.setDefaultTimeout(120_000); // drawn in software, perhaps beside other work
  await tab.goto(server.url, { waitUntil: 'commit' });
  await tab.waitForFunction(() => Boolean(window.brim));
  await tab.evaluate(() => window.brim.ready);
  return { page: tab, run, server, problems, requests };
}

export async function close({ page: tab, server }: Opened): Promise<void> {
  await tab.close();
  await server.stop();
}
