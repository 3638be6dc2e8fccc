/** Ties the page together: what the server sends, what the person asks for, and what is drawn. */
import { fetchFrame, fetchRun, fetchSeries, fetchSlice, fetchTopology, watchProgress } from './client';
import { FrameCache } from './frame_cache';
import { Picture } from './picture';
import { Player } from './player';
import type { Frame, RunInfo, Series } from './run';
import { defaultPose, type CameraPose } from './scene/stage';
import type { Slice, SliceWish } from './slice';
import { download, film, padded, pictureSequence, pngOf } from './ui/capture';
import { h, human, iconButton } from './ui/dom';
import { bindKeys } from './ui/keys';
import { helpDialog, Panel, PickCard } from './ui/panel';
import { appendSeries } from './ui/plot_data';
import { Plots } from './ui/plots';
import { Timeline } from './ui/timeline';

const kCompact = 900; // [CSS pixels] below which the side panels cover the picture, one at a time

export class App {
  readonly player = new Player();
  readonly picture: Picture;
  readonly panel: Panel;
  run: RunInfo | undefined;
  private readonly canvas = h('canvas', {
    class: 'picture',
    tabIndex: 0,
    'aria-label': 'picture of the run',
  });
  private readonly plots: Plots;
  private readonly timeline: Timeline;
  private readonly pick = new PickCard();
  private readonly help = helpDialog();
  private readonly banner = h('div', { class: 'banner', hidden: true, role: 'status' });
  private readonly notices = new Map<string, string>();
  private readonly view: HTMLElement;
  private readonly cache = new FrameCache(fetchFrame);
  private series: Series = new Map();
  private requested: number | undefined; // frame on its way to the picture
  private failed = -1; // frame the server could not give
  private stopCapture = false;
  private capturing = false; // frames are shown one by one for pictures: the clock rests
  private slice: Slice | undefined; // the last that came
  private sliceKey = ''; // what was asked for it
  private slicing: Promise<void> | undefined;
  private updating: Promise<void> | undefined;
  private updateAgain = false;
  private lastTick = 0;

  constructor(private readonly bare: boolean) {
    this.picture = new Picture(this.canvas);
    const hover = (frame: number | undefined) => {
      this.plots.hover(frame);
      this.timeline.hover(frame);
    };
    this.plots = new Plots(this.player, hover);
    this.timeline = new Timeline(this.player, hover);
    this.panel = new Panel(this.player, {
      look: (body, look) => {
        this.picture.setLook(body, look);
        this.drawSlice();
      },
      contacts: (style, scale) => this.picture.setContacts(style, scale),
      tiles: (on) => this.picture.setTiles(on),
      slice: () => void this.refreshSlice(),
    });
    this.view = h('main', { class: 'view' }, this.canvas, this.banner, this.pick.element);
    document.body.classList.toggle('bare', bare);
    document.body.append(
      this.header(),
      this.panel.element,
      this.view,
      this.plots.element,
      this.timeline.element,
      this.help,
    );
    if (window.innerWidth < kCompact) this.panel.element.hidden = this.plots.element.hidden = true;
    bindKeys(this);
    this.bindPicking();
    if (!bare) new ResizeObserver(() => this.resize()).observe(this.view);
    this.resize();
  }

  private header(): HTMLElement {
    const record = iconButton('film', 'film the run (WebM)', () => void this.toggleFilm(), {
      class: 'icon record',
    });
    return h(
      'header',
      { class: 'bar' },
      iconButton('panel', 'bodies and contacts (b)', () => this.togglePanel()),
      h('b', { class: 'logo' }, 'brim'),
      h('span', { class: 'title' }),
      h('span', { class: 'spacer' }),
      iconButton('fit', 'fit the view (f)', () => this.fit()),
      iconButton('camera', 'save a picture (s)', () => void this.savePicture()),
      record,
      h(
        'button',
        {
          class: 'text',
          type: 'button',
          title: 'save every frame as a picture',
          onclick: () => void this.saveSequence(),
        },
        'PNGs',
      ),
      iconButton('help', 'keys (?)', () => this.toggleHelp()),
      iconButton('chart', 'plots (p)', () => this.togglePlots()),
    );
  }

  /** Loads the run, then keeps up with it; waits for a server that is not there yet. */
  async start(): Promise<void> {
    for (;;) {
      try {
        await this.load();
        break;
      } catch (error) {
        if (this.bare) throw error;
        this.notice('load', `The run cannot be loaded: ${(error as Error).message}. Trying again…`);
        await new Promise((done) => setTimeout(done, 1500));
      }
    }
    this.notice('load');
    if (!this.bare)
      watchProgress({
        progress: (p) => {
          if (p.frames !== this.run?.frames || p.complete !== this.run.complete) void this.update();
        },
        lost: () =>
          this.notice(
            'lost',
            'The server does not answer. What has been loaded still plays; waiting for it to come back…',
          ),
        found: () => {
          this.notice('lost');
          this.failed = -1;
          void this.update();
        },
      });
    this.lastTick = performance.now();
    if (!this.bare) requestAnimationFrame(this.tick);
  }

  private async load(): Promise<void> {
    const run = await fetchRun();
    const [topologies, series] = await Promise.all([
      Promise.all(run.bodies.map((b) => fetchTopology(b.index))),
      fetchSeries(0),
    ]);
    this.run = run;
    this.setSeries(series);
    const samples = await this.samples();
    this.picture.setRun(run, topologies, samples);
    this.picture.stage.setPose(defaultPose);
    this.panel.setRun(run, this.picture.colours);
    this.panel.slice.setRun(run.bodies, run.slices === true, this.picture.stage.center.toArray());
    this.describe();
    if (samples[0]) this.display(samples[0]);
  }

  /** First, middle and last frame, as far as they can be read. */
  private async samples(): Promise<Frame[]> {
    const last = this.player.frames - 1;
    const wanted = [...new Set([0, Math.floor(last / 2), last])].filter((f) => f >= 0);
    const got = await Promise.allSettled(wanted.map((f) => this.cache.get(f)));
    return got.flatMap((g) => (g.status === 'fulfilled' ? [g.value] : []));
  }

  /** Takes in what a growing run has gained. One at a time; news that arrive meanwhile are fetched after. */
  private update(): Promise<void> {
    this.updateAgain = true;
    this.updating ??= (async () => {
      try {
        while (this.updateAgain) {
          this.updateAgain = false;
          await this.updateOnce();
        }
      } catch {
        // The server is gone again; its return starts another update.
      } finally {
        this.updating = undefined;
      }
    })();
    return this.updating;
  }

  private async updateOnce(): Promise<void> {
    const run = await fetchRun();
    const known = this.player.frames;
    const other = run.frames < known || JSON.stringify(run.bodies) !== JSON.stringify(this.run?.bodies);
    if (other) return location.reload(); // another run is served now
    this.run = run;
    this.failed = -1; // what could not be read while it was written may be whole now
    if (run.frames > known) {
      const following = known > 1 && this.player.frame === known - 1 && !this.player.playing;
      this.setSeries(appendSeries(this.series, await fetchSeries(known)));
      if (known === 0) {
        this.picture.frameScene(await this.samples());
        this.panel.slice.setRun(run.bodies, run.slices === true, this.picture.stage.center.toArray());
        this.picture.stage.setPose(defaultPose);
      }
      if (following) this.player.seek(this.player.frames - 1);
    }
    this.panel.setRun(run, this.picture.colours);
    this.describe();
  }

  private setSeries(series: Series) {
    this.series = series;
    this.player.setTimes(series.get('time') ?? new Float64Array(0));
    this.plots.setSeries(series, this.run?.sensors);
  }

  private describe() {
    const { run } = this;
    if (!run) return;
    document.title = `${run.name} · brim`;
    document.querySelector('.title')!.textContent = run.name;
    this.timeline.showWarnings(run.warnings);
    const none = this.player.frames === 0;
    this.notice(
      'empty',
      !none
        ? undefined
        : run.complete
          ? 'This run has no frames.'
          : 'No frames yet. They appear here as the run writes them.',
    );
  }

  private readonly tick = (now: number) => {
    if (!this.capturing) {
      this.player.advance(Math.min(0.25, (now - this.lastTick) / 1000));
      this.follow();
    }
    this.lastTick = now;
    this.picture.stage.draw();
    requestAnimationFrame(this.tick);
  };

  /** Brings the player's frame into the picture, at once if it is here, else when it comes. */
  private follow() {
    const { player, cache } = this;
    const wanted = player.frame;
    if (player.frames === 0 || this.requested !== undefined) return;
    if (this.picture.shown?.index !== wanted && this.failed !== wanted) {
      const here = cache.peek(wanted);
      if (here) this.display(here);
      else {
        this.requested = wanted;
        cache
          .get(wanted)
          .then((frame) => {
            this.failed = -1;
            this.notice('frame');
            this.display(frame);
          })
          .catch((error: unknown) => {
            this.failed = wanted;
            if (!this.notices.has('lost'))
              this.notice('frame', `Frame ${wanted + 1} cannot be shown: ${(error as Error).message}`);
          })
          .finally(() => (this.requested = undefined));
      }
    }
    if (player.playing) {
      const stride = Math.max(1, Math.round(player.speed));
      const ahead = Array.from({ length: 8 }, (_, i) => (wanted + (i + 1) * stride) % player.frames);
      cache.prefetch(ahead);
    }
  }

  private display(frame: Frame) {
    this.picture.show(frame, (body) => this.panel.looks[body]?.visible ?? true);
    if (this.notices.has('frame') && frame.index === this.player.frame) this.notice('frame');
    if (!this.bare) this.panel.showFrame(frame);
    if (this.panel.slice.on) void this.refreshSlice();
  }

  /** Asks for the plane that is wanted until it is there: only the latest wish counts while one is on its way. */
  private refreshSlice(): Promise<void> {
    const card = this.panel.slice;
    if (!card.on || !this.picture.shown) {
      this.drawSlice();
      return Promise.resolve();
    }
    this.slicing ??= (async () => {
      try {
        for (;;) {
          const { shown } = this.picture;
          const wish = card.wish;
          const key = `${shown?.index} ${JSON.stringify(wish)}`;
          if (!card.on || !shown || key === this.sliceKey) break;
          try {
            this.slice = await fetchSlice(shown.index, wish);
            card.show(this.slice);
          } catch (error) {
            this.slice = undefined;
            card.fail((error as Error).message);
          }
          this.sliceKey = key;
          this.drawSlice();
        }
      } finally {
        this.slicing = undefined;
      }
      this.drawSlice();
    })();
    return this.slicing;
  }

  private drawSlice() {
    const card = this.panel.slice;
    const colours = this.panel.looks.map((l) => l.colour);
    this.picture.setSlice(card.on ? this.slice : undefined, colours, card.wish.body >= 0, card.cut);
  }

  /** Shows the densities on a plane; a body is given by name. For pictures. */
  async showSlice(wish: { axis: number; at?: number; body?: string }): Promise<void> {
    const { body, ...rest } = wish;
    const known = this.run?.bodies.find((b) => b.name === body)?.index;
    if (body !== undefined && known === undefined) throw new Error(`no body is named "${body}"`);
    if (!this.run?.slices) throw new Error('this run keeps no scene to make densities from');
    const full: Partial<SliceWish> = body === undefined ? rest : { ...rest, body: known! };
    this.panel.slice.set(full);
    await this.refreshSlice();
  }

  /** Brings a frame that is at hand into picture and panel, without drawing. */
  showNow(frame: Frame): void {
    this.display(frame);
  }

  /** Shows one frame and draws it before it returns: for pictures. */
  async showFrame(index: number): Promise<void> {
    this.player.playing = false;
    this.player.seek(index);
    if (this.player.frames > 0) this.display(await this.cache.get(this.player.frame));
    await this.refreshSlice();
    await this.picture.settled();
    this.picture.stage.draw(true);
  }

  /** Makes the picture this large, [pixels], whatever the window's size. */
  setSize(width: number, height: number): void {
    this.picture.stage.resize(width, height, 1);
  }

  /** One frame as a PNG, in base64. */
  async png(index: number): Promise<string> {
    await this.showFrame(index);
    return this.canvas.toDataURL('image/png').split(',')[1]!;
  }

  /** Brings what is shown now into the picture, and the light with it. */
  fit(): void {
    if (this.picture.shown) this.picture.frameScene([this.picture.shown]);
    this.picture.stage.fit();
  }

  /** Fits light and ground to one frame instead of the whole run: for a picture of it. */
  async frameOn(index: number): Promise<void> {
    if (this.player.frames > 0) this.picture.frameScene([await this.cache.get(index)]);
  }

  setPose(pose: CameraPose): void {
    this.picture.stage.setPose(pose);
  }

  private resize() {
    const box = this.view.getBoundingClientRect();
    if (box.width > 0 && box.height > 0) this.picture.stage.resize(box.width, box.height);
    this.picture.stage.draw(true);
  }

  /** A line above the picture under a name; no text takes it away. */
  notice(name: string, text?: string): void {
    if (this.notices.get(name) === text) return;
    if (text) this.notices.set(name, text);
    else this.notices.delete(name);
    this.banner.hidden = this.notices.size === 0;
    this.banner.replaceChildren(
      ...[...this.notices].map(([key, line]) => h('p', { 'data-notice': key }, line)),
    );
  }

  // What the buttons and keys do.

  togglePanel(): void {
    this.toggleSide(this.panel.element, this.plots.element);
  }
  togglePlots(): void {
    this.toggleSide(this.plots.element, this.panel.element);
    this.plots.draw();
  }
  private toggleSide(side: HTMLElement, other: HTMLElement) {
    side.hidden = !side.hidden;
    if (!side.hidden && window.innerWidth < kCompact) other.hidden = true;
  }
  toggleHelp(): void {
    if (this.help.open) this.help.close();
    else this.help.showModal();
  }

  async savePicture(): Promise<void> {
    this.picture.stage.draw(true);
    download(await pngOf(this.canvas), `${this.fileName()}_${padded(this.player.frame)}.png`);
  }

  private fileName(): string {
    return (this.run?.name ?? 'run').replaceAll(/[^\w.-]+/g, '_');
  }

  /** Goes through the run for pictures or a film; escape stops. `make` gets what asks whether to go on. */
  private async capture(
    what: string,
    make: (goOn: (done: number, all: number) => boolean) => Promise<void>,
  ): Promise<void> {
    if (this.capturing || this.player.frames === 0) return;
    this.capturing = true;
    this.stopCapture = false;
    const onKey = (e: KeyboardEvent) => (this.stopCapture ||= e.key === 'Escape');
    window.addEventListener('keydown', onKey);
    try {
      await make((done, all) => {
        this.notice('capture', `${what}: ${done} of ${all} (escape stops)`);
        return !this.stopCapture;
      });
      this.notice('capture');
    } catch (error) {
      this.notice('capture', `${what} failed: ${(error as Error).message}`);
    } finally {
      window.removeEventListener('keydown', onKey);
      this.capturing = false;
    }
  }

  async saveSequence(): Promise<void> {
    await this.capture('Saving pictures', async (goOn) => {
      const { frames } = this.player;
      const blob = await pictureSequence(
        this.canvas,
        frames,
        (f) => this.showFrame(f),
        (done) => goOn(done, frames),
      );
      if (blob) download(blob, `${this.fileName()}.zip`);
    });
  }

  /** Films the run once through; a film that is being made ends early, and is saved so far. */
  async toggleFilm(): Promise<void> {
    if (this.capturing) {
      this.stopCapture = true;
      return;
    }
    document.body.classList.add('filming');
    await this.capture('Filming', async (goOn) => {
      const blob = await film(this.canvas, this.player, (f) => this.showFrame(f), goOn);
      download(blob, `${this.fileName()}.webm`);
    });
    document.body.classList.remove('filming');
  }

  /** A click that is not a drag picks what is under it. */
  private bindPicking() {
    let down: PointerEvent | undefined;
    this.canvas.addEventListener('pointerdown', (e) => (down = e));
    this.canvas.addEventListener('pointerup', (e) => {
      if (!down || down.button !== 0 || Math.hypot(e.clientX - down.clientX, e.clientY - down.clientY) > 4)
        return;
      const box = this.canvas.getBoundingClientRect();
      this.pickAt((2 * (e.clientX - box.left)) / box.width - 1, 1 - (2 * (e.clientY - box.top)) / box.height);
    });
  }

  /** What a body touches in the frame shown, with the normal force of each pair. */
  private touching(body: number): [string, string][] {
    const part = (p: number) => this.run?.parts[p];
    return (this.picture.shown?.pairs ?? [])
      .filter((t) => (part(t.a)?.body === body) !== (part(t.b)?.body === body))
      .sort((s, t) => t.normal - s.normal)
      .slice(0, 6)
      .map((t) => [
        'touches',
        `${part(part(t.a)?.body === body ? t.b : t.a)?.name ?? '?'}, ${human(t.normal, 'N')}`,
      ]);
  }

  pickAt(x: number, y: number): void {
    const picked = this.picture.pick(x, y);
    const point = (p: ArrayLike<number>) => [0, 1, 2].map((k) => (p[k] ?? 0).toFixed(4)).join(', ') + ' m';
    if (!picked) return this.pick.hide();
    if (picked.contact !== undefined && this.picture.shown) {
      const c = this.picture.shown.contacts;
      const i = picked.contact;
      const name = (part: number) => this.run?.parts[part]?.name ?? `part ${part}`;
      const size = (v: Float32Array) =>
        human(Math.hypot(v[3 * i] ?? 0, v[3 * i + 1] ?? 0, v[3 * i + 2] ?? 0), 'N');
      this.pick.show('Contact', [
        ['between', `${name(c.pair[2 * i]!)} and ${name(c.pair[2 * i + 1]!)}`],
        ['at', point(c.position.subarray(3 * i, 3 * i + 3))],
        ['normal force', size(c.force)],
        ['friction', size(c.friction)],
        ['overlap', `${human(c.overlap[i] ?? 0)} voxels`],
      ]);
    } else if (picked.body) {
      const at = this.picture.positionOf(picked.body.index, picked.vertex ?? -1);
      this.pick.show(picked.body.name, [
        ['kind', picked.body.kind],
        ['clicked at', point([picked.at.x, picked.at.y, picked.at.z])],
        ['nearest point', `number ${picked.vertex}`],
        ...(at ? [['lies at', point(at)] as [string, string]] : []),
        ['points', this.picture.pointsOf(picked.body.index).toLocaleString('en')],
        ...this.touching(picked.body.index),
      ]);
    }
  }
}
