// Makes pictures of a run for `brim render`: drives the viewer's own page in Chromium without a window, so that a
// picture on disk is what the viewer shows. Speaks Chromium's DevTools protocol over a pipe and needs nothing but Node.
//   node render.mjs '{"url": ..., "out": ..., "chromium": ..., "ffmpeg": ..., "frame": ..., "width": ..., ...}'
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { existsSync, mkdtempSync, mkdirSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';

const kPatience = 300_000; // [ms] for one answer; a first picture drawn in software may take a minute

class Browser {
  constructor(program, profile) {
    this.next = 0;
    this.waiting = new Map();
    this.process = spawn(
      program,
      [
        '--headless=new',
        '--no-sandbox', // containers have no sandbox to give; only this machine's own page is opened
        '--use-gl=angle',
        '--use-angle=swiftshader',
        '--enable-unsafe-swiftshader',
        '--remote-debugging-pipe',
        `--user-data-dir=${profile}`,
        '--no-first-run',
        '--no-default-browser-check',
        '--disable-quic',
        '--disable-background-networking',
        '--disable-component-update',
        '--disable-sync',
        '--disable-dev-shm-usage',
        '--hide-scrollbars',
        'about:blank',
      ],
      { stdio: ['ignore', 'ignore', 'pipe', 'pipe', 'pipe'] },
    );
    this.complaints = '';
    this.process.stderr.on('data', (text) => (this.complaints = (this.complaints + text).slice(-4000)));
    this.process.on('error', (error) =>
      this.fail(new Error(`${program} cannot be started: ${error.message}`)),
    );
    this.process.on('exit', () => this.fail(new Error(`${program} ended early:\n${this.complaints}`)));
    this.process.stdio[3].on('error', () => undefined); // its end is told by 'exit'
    let pending = Buffer.alloc(0);
    const pieces = [];
    this.process.stdio[4].on('data', (data) => {
      // Messages end with a zero byte and may come in pieces.
      for (;;) {
        const end = data.indexOf(0);
        if (end < 0) break;
        pieces.push(data.subarray(0, end));
        pending = Buffer.concat(pieces);
        pieces.length = 0;
        this.receive(JSON.parse(pending.toString('utf8')));
        data = data.subarray(end + 1);
      }
      if (data.length) pieces.push(data);
    });
  }

  receive(message) {
    const waiting = this.waiting.get(message.id);
    if (!waiting) return;
    this.waiting.delete(message.id);
    clearTimeout(waiting.timer);
    if (message.error) waiting.fail(new Error(message.error.message));
    else waiting.done(message.result);
  }

  fail(error) {
    for (const { fail, timer } of this.waiting.values()) {
      clearTimeout(timer);
      fail(error);
    }
    this.waiting.clear();
  }

  send(method, params = {}) {
    const id = ++this.next;
    return new Promise((done, fail) => {
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        fail(new Error(`no answer to ${method} in ${kPatience / 1000} s`));
      }, kPatience);
      this.waiting.set(id, { done, fail, timer });
      this.process.stdio[3].write(JSON.stringify({ id, method, params, sessionId: this.session }) + '\0');
    });
  }

  async evaluate(expression) {
    const answer = await this.send('Runtime.evaluate', {
      expression,
      awaitPromise: true,
      returnByValue: true,
    });
    if (answer.exceptionDetails)
      throw new Error(
        answer.exceptionDetails.exception?.description?.split('\n')[0].replace(/^Error: /, '') ??
          answer.exceptionDetails.text,
      );
    return answer.result.value;
  }

  async open(url, width, height) {
    const { targetId } = await this.send('Target.createTarget', { url: 'about:blank' });
    this.session = (await this.send('Target.attachToTarget', { targetId, flatten: true })).sessionId;
    await this.send('Emulation.setDeviceMetricsOverride', {
      width,
      height,
      deviceScaleFactor: 1,
      mobile: false,
    });
    await this.send('Page.enable');
    await this.send('Page.navigate', { url });
    const end = Date.now() + kPatience;
    while (!(await this.evaluate('Boolean(window.brim)'))) {
      if (Date.now() > end) throw new Error(`${url} did not open`);
      await new Promise((done) => setTimeout(done, 100));
    }
    await this.evaluate('brim.ready.then(() => true)');
  }

  async close() {
    this.process.removeAllListeners('exit');
    if (this.process.exitCode !== null || this.process.pid === undefined) return;
    const gone = once(this.process, 'close');
    this.session = undefined; // the browser itself is meant
    this.send('Browser.close').catch(() => undefined);
    const timer = setTimeout(() => this.process.kill('SIGKILL'), 5000);
    await gone;
    clearTimeout(timer);
    this.fail(new Error('the browser was closed'));
  }
}

/** Takes PNGs one by one and makes a film of them. */
class Film {
  constructor(ffmpeg, fps, out) {
    const [program, ...options] = [
      ffmpeg,
      '-hide_banner',
      '-loglevel',
      'error',
      '-y',
      '-f',
      'image2pipe',
      '-framerate',
      String(fps),
      '-i',
      '-',
      '-c:v',
      'libx264',
      '-crf',
      '17',
      '-pix_fmt',
      'yuv420p',
      '-movflags',
      '+faststart',
      out,
    ];
    this.process = spawn(program, options, { stdio: ['pipe', 'inherit', 'inherit'] });
    this.process.stdin.on('error', () => undefined); // its exit code tells
    this.ended = once(this.process, 'close');
    this.ended.catch(() => undefined);
  }
  async add(png) {
    if (!this.process.stdin.write(png)) await Promise.race([once(this.process.stdin, 'drain'), this.ended]);
  }
  async finish() {
    this.process.stdin.end();
    const [code] = await this.ended;
    if (code !== 0) throw new Error(`ffmpeg failed with exit code ${code}`);
  }
}

const kPicture = /^frame_(\d{5,})\.png$/;

/** Folder of a film's pictures, where there is no ffmpeg: beside the film, and not one that holds anything else. */
function pictureFolder(film) {
  const plain = film.replace(/\.mp4$/, '');
  const free = (folder) => !existsSync(folder) || readdirSync(folder).every((name) => kPicture.test(name));
  for (let n = 1; ; ++n) {
    const folder = n === 1 ? plain : `${plain}_frames${n === 2 ? '' : `_${n - 1}`}`;
    if (free(folder)) return folder;
  }
}

/** Of an earlier, longer film: what its pictures would add to the end of this one. */
function removeLaterPictures(folder, frames) {
  for (const name of readdirSync(folder))
    if (Number(kPicture.exec(name)?.[1] ?? -1) >= frames) rmSync(join(folder, name));
}

async function main() {
  const job = JSON.parse(process.argv[2]);
  const movie = job.out.endsWith('.mp4');
  // Films are coded in blocks of two pixels.
  const [width, height] = movie ? [job.width & ~1, job.height & ~1] : [job.width, job.height];
  const profile = mkdtempSync(join(tmpdir(), 'brim-render-'));
  const browser = new Browser(job.chromium, profile);
  const stop = () => void browser.close().then(() => process.exit(130));
  process.on('SIGINT', stop);
  process.on('SIGTERM', stop);
  try {
    await browser.open(`${job.url}?bare`, width, height);
    await browser.evaluate(`brim.app.setSize(${width}, ${height})`);
    const frames = await browser.evaluate('brim.app.player.frames');
    if (!(frames > 0)) throw new Error('this run has no frames');
    const frame = job.frame < 0 ? frames + job.frame : job.frame;
    if (!movie && !(frame >= 0 && frame < frames))
      throw new Error(`frame ${job.frame} is not there; the run has ${frames}`);
    // A film shows all that happens; a picture fits its own frame.
    if (!movie) await browser.evaluate(`brim.app.frameOn(${frame})`);
    await browser.evaluate(`brim.app.setPose(${JSON.stringify(job.camera)})`);
    if (job.contacts) await browser.evaluate(`brim.app.panel.setContacts(${JSON.stringify(job.contacts)})`);
    if (job.colours) await browser.evaluate(`brim.app.panel.setColours(${JSON.stringify(job.colours)})`);
    if (job.surface) await browser.evaluate(`brim.app.panel.setSurfaces(${JSON.stringify(job.surface)})`);
    if (job.tiles) await browser.evaluate('brim.app.panel.setTiles(true)');
    if (job.links === false) await browser.evaluate('brim.app.panel.setLinks(false)');
    if (job.slice)
      await browser.evaluate(`brim.app.showSlice(${JSON.stringify(job.slice)}).then(() => true)`);
    if (job.stress !== null) await browser.evaluate(`brim.app.showStress(${job.stress}).then(() => true)`);
    const picture = async (f) => Buffer.from(await browser.evaluate(`brim.app.png(${f})`), 'base64');
    mkdirSync(dirname(job.out), { recursive: true });
    if (!movie) {
      writeFileSync(job.out, await picture(frame));
      if (job.stress !== null)
        console.log(`stress: colours from 0 to ${await browser.evaluate('brim.app.panel.stress.top')} Pa`);
      return;
    }
    let film;
    let folder;
    if (job.ffmpeg) film = new Film(job.ffmpeg, job.fps, job.out);
    else {
      folder = pictureFolder(job.out);
      mkdirSync(folder, { recursive: true });
      console.error(`brim: ffmpeg is not installed; pictures go to ${folder}/ instead of ${job.out}`);
    }
    for (let f = 0; f < frames; ++f) {
      const png = await picture(f);
      if (film) await film.add(png);
      else writeFileSync(join(folder, `frame_${String(f).padStart(5, '0')}.png`), png);
      if (process.stderr.isTTY) process.stderr.write(`\rframe ${f + 1} of ${frames} `);
    }
    if (process.stderr.isTTY) process.stderr.write('\n');
    await film?.finish();
    if (folder) removeLaterPictures(folder, frames);
  } finally {
    await browser.close();
    try {
      rmSync(profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 100 });
    } catch {
      // A straggler of the browser still writes there; a stray temporary folder is no reason to fail.
    }
  }
}

main().then(
  () => process.exit(0),
  (error) => {
    console.error(`brim: error: ${error.message}`);
    process.exit(1);
  },
);
