/** Serves a made-up run over the viewer's HTTP interface, for development and for the browser tests. */
import { createReadStream, existsSync, statSync } from 'node:fs';
import { createServer, type IncomingMessage, type Server, type ServerResponse } from 'node:http';
import type { AddressInfo } from 'node:net';
import { extname, join, normalize } from 'node:path';
import type { FakeRun } from './fake_run';

const mimeTypes: Record<string, string> = {
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript',
  '.css': 'text/css',
  '.svg': 'image/svg+xml',
};

function send(response: ServerResponse, status: number, type: string, body: string | ArrayBuffer) {
  response.writeHead(status, { 'Content-Type': type, 'Cache-Control': 'no-store' });
  response.end(typeof body === 'string' ? body : Buffer.from(body));
}

const json = (response: ServerResponse, status: number, value: unknown) =>
  send(response, status, 'application/json', JSON.stringify(value));

function binary(response: ServerResponse, body: ArrayBuffer | undefined, what: string) {
  if (body) send(response, 200, 'application/octet-stream', body);
  else json(response, 404, { error: `no ${what}` });
}

/** Tells the open page of new frames until the connection closes. */
function events(run: FakeRun, request: IncomingMessage, response: ServerResponse) {
  response.writeHead(200, { 'Content-Type': 'text/event-stream', 'Cache-Control': 'no-store' });
  let told = '';
  const tell = () => {
    const now = JSON.stringify({ frames: run.frames, complete: run.complete, stopped: run.stopped });
    if (now !== told) response.write(`event: frames\ndata: ${now}\n\n`);
    told = now;
  };
  tell();
  const timer = setInterval(tell, 100);
  request.on('close', () => clearInterval(timer));
}

/** Answers a request under /api/; false when it is for something else. */
export function handleApi(run: FakeRun, request: IncomingMessage, response: ServerResponse): boolean {
  const url = new URL(request.url ?? '/', 'http://localhost');
  const [api, what, which] = url.pathname.split('/').slice(1);
  if (api !== 'api') return false;
  if (request.method === 'POST' && run.interactive) {
    run.asked.push(`${what}${url.search}`);
    json(response, 200, {});
  } else if (what === 'run') json(response, 200, run.info());
  else if (what === 'topology') binary(response, run.topology(Number(which)), `body ${which}`);
  else if (what === 'frame') {
    if (run.broken.has(Number(which)))
      json(response, 500, { error: `frame ${which} cannot be read: the file is damaged` });
    else binary(response, run.frame(Number(which)), `frame ${which}`);
  } else if (what === 'series')
    binary(response, run.series(Number(url.searchParams.get('from') ?? 0)), 'series');
  else if (what === 'slice') {
    const n = (name: string, otherwise: string) => Number(url.searchParams.get(name) ?? otherwise);
    const wish = { axis: n('axis', '2'), at: n('at', '0'), body: n('body', '-1') };
    binary(response, run.slice(Number(which), wish), `frame ${which}`);
  } else if (what === 'stress') binary(response, run.stress(Number(which)), `frame ${which}`);
  else if (what === 'events') events(run, request, response);
  else json(response, 404, { error: `nothing at ${url.pathname}` });
  return true;
}

export interface FakeServer {
  url: string;
  port: number;
  stop(): Promise<void>;
}

export async function startFakeServer(run: FakeRun, folder: string, port = 0): Promise<FakeServer> {
  const server: Server = createServer((request, response) => {
    if (handleApi(run, request, response)) return;
    const path = normalize(new URL(request.url ?? '/', 'http://localhost').pathname);
    const file = join(folder, path === '/' ? 'index.html' : path);
    if (!existsSync(file) || !statSync(file).isFile()) return json(response, 404, { error: 'not found' });
    response.writeHead(200, { 'Content-Type': mimeTypes[extname(file)] ?? 'application/octet-stream' });
    createReadStream(file).pipe(response);
  });
  await new Promise<void>((done) => server.listen(port, '127.0.0.1', done));
  const actual = (server.address() as AddressInfo).port;
  return {
    url: `http://127.0.0.1:${actual}/`,
    port: actual,
    stop: () =>
      new Promise<void>((done) => {
        server.close(() => done());
        server.closeAllConnections();
      }),
  };
}
