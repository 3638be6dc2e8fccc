/** Ties the page together: what the server sends, what the person asks for, and what is drawn. */
import { fetchFrame, fetchRun, fetchSeries, fetchTopology, watchProgress } from './client';
import { FrameCache } from './frame_cache';
import { FrameFollower } from './frame_follower';
import { Picture } from './picture';
import { Player } from './player';
import type { Frame, RunInfo, Series } from './run';
import { defaultPose, type CameraPose } from './scene/stage';
import { Slicing, type NamedSlice } from './slicing';
import { Stressing } from './stressing';
import { Captures } from './ui/captures';
import { h } from './ui/dom';
import { headerBar } from './ui/header';
import { bindKeys } from './ui/keys';
import { Notices } from './ui/notices';
import { helpDialog, Panel } from './ui/panel';
import { Picking } from './ui/picking';
import { appendSeries } from './ui/plot_data';
import { Plots } from './ui/plots';
import { Pulling } from './ui/pulling';
import { Timeline } from './ui/timeline';

const kSamples = 9; // frames over the run whose bodies the picture is fitted to
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
  readonly captures: Captures;
  private readonly picking: Picking;
  private readonly pulling: Pulling;
  private readonly slicing: Slicing;
  private readonly stressing: Stressing;
  private readonly notices = new Notices();
  private readonly help = helpDialog();
  private readonly view: HTMLElement;
  private readonly cache = new FrameCache(fetchFrame);
  private readonly follower = new FrameFollower(this.player, this.cache, this.notices, {
    shown: () => this.picture.shown?.index,
    display: (frame) => this.display(frame),
  });
  private series: Series = new Map();
  private updating: Promise<void> | undefined;
  private updateAgain = false;
  private lastTick = 0;
  private compact = false; // the window is narrow

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
        this.slicing.draw();
      },
      contacts: (style, scale) => this.picture.setContacts(style, scale),
      tiles: (on) => this.picture.setTiles(on),
      links: (on) => this.picture.setLinks(on),
      slice: () => void this.slicing.refresh(),
      stress: () => void this.stressing.refresh(),
      middle: () => (this.bare ? this.picture.stage.center.toArray() : this.picture.middle()),
    });
    this.slicing = new Slicing(this.picture, this.panel);
    this.stressing = new Stressing(this.picture, this.panel.stress);
    this.picking = new Picking(this.canvas, this.picture, () => this.run);
    this.pulling = new Pulling(this.canvas, this.picture, this.notices, () =>
      this.acting && this.player.frame === this.player.frames - 1 ? this.run : undefined,
    );
    this.captures = new Captures(this.canvas, this.player, this.notices, {
      name: () => this.run?.name,
      redraw: () => this.picture.stage.draw(true),
      showFrame: (frame) => this.showFrame(frame),
    });
    this.view = h('main', { class: 'view' }, this.canvas, this.notices.element, this.picking.element);
    document.body.classList.toggle('bare', bare);
    document.body.append(
      headerBar(this),
      this.panel.element,
      this.view,
      this.plots.element,
      this.timeline.element,
      this.help,
    );
    bindKeys(this);
    if (!bare) new ResizeObserver(() => this.resize()).observe(this.view);
    this.resize();
  }

  /** Loads the run, then keeps up with it; waits for a server that is not there yet. */
  async start(): Promise<void> {
    if (!this.bare) this.notices.set('load', 'Reading the run…');
    for (;;) {
      try {
        await this.load();
        break;
      } catch (error) {
        if (this.bare) throw error;
        this.notices.set('load', `The run cannot be loaded: ${(error as Error).message}. Trying again…`);
        await new Promise((done) => setTimeout(done, 1500));
      }
    }
    this.notices.set('load');
    if (!this.bare)
      watchProgress({
        progress: (p) => {
          if (p.frames !== this.run?.frames || p.complete !== this.run.complete) void this.update();
        },
        lost: () =>
          this.notices.set(
            'lost',
            'The server does not answer. What has been loaded still plays; waiting for it to come back…',
          ),
        found: () => {
          this.notices.set('lost');
          this.follower.tryAgain();
          void this.update();
        },
      });
    this.lastTick = performance.now();
    if (!this.bare) requestAnimationFrame(this.tick);
  }

  /** The run is made now, and its bodies can be pulled. */
  private get acting(): boolean {
    return this.run?.interactive === true && !this.run.complete;
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
    this.panel.slice.setRun(run.bodies, run.slices === true);
    this.describe();
    if (samples[0]) this.display(samples[0]);
    if (this.acting) this.player.seek(this.player.frames - 1);
  }

  /** Some frames from the first to the last, as far as they can be read. */
  private async samples(): Promise<Frame[]> {
    const last = this.player.frames - 1;
    const evenly = Array.from({ length: kSamples }, (_, k) => Math.floor((last * k) / (kSamples - 1)));
    const wanted = [...new Set(evenly)].filter((f) => f >= 0);
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
    this.follower.tryAgain(); // what could not be read while it was written may be whole now
    const grown = run.frames > known;
    const following =
      grown && (known > 1 || this.acting) && this.player.frame === known - 1 && !this.player.playing;
    if (grown) this.setSeries(appendSeries(this.series, await fetchSeries(known)));
    this.panel.setRun(run, this.picture.colours);
    this.describe(); // at once: the first frames may be shown while the samples below are fetched
    if (grown && known === 0) {
      this.picture.frameScene(await this.samples());
      this.panel.slice.setRun(run.bodies, run.slices === true);
      this.picture.stage.setPose(defaultPose);
    }
    if (following) this.player.seek(this.player.frames - 1);
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
    this.notices.set(
      'empty',
      !none
        ? undefined
        : run.complete
          ? 'This run has no frames.'
          : 'No frames yet. They appear here as the run writes them.',
    );
  }

  private readonly tick = (now: number) => {
    if (!this.captures.running) {
      this.player.advance(Math.min(0.25, (now - this.lastTick) / 1000));
      this.follower.follow();
    }
    this.lastTick = now;
    this.picture.stage.draw();
    requestAnimationFrame(this.tick);
  };

  private display(frame: Frame) {
    this.picture.show(frame, (body) => this.panel.looks[body]?.visible ?? true);
    if (this.notices.has('frame') && frame.index === this.player.frame) this.notices.set('frame');
    if (!this.bare) this.panel.showFrame(frame);
    if (this.panel.slice.on) void this.slicing.refresh();
    if (this.panel.stress.on) void this.stressing.refresh();
    this.pulling.refresh();
  }

  /** Shows the densities on a plane; a body is given by name. For pictures. */
  showSlice(wish: NamedSlice): Promise<void> {
    return this.slicing.show(this.run, wish);
  }

  /** Colours elastic solids by their stress. @param top [Pa] of the last colour; 0: the largest of each frame */
  showStress(top: number): Promise<void> {
    return this.stressing.show(this.run, top);
  }

  /** Reads what is under a place of the picture, from -1 to 1 to the right and up. */
  pickAt(x: number, y: number): void {
    this.picking.pickAt(x, y);
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
    await this.slicing.refresh();
    await this.stressing.refresh();
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
    this.picture.follow(undefined);
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
    const compact = window.innerWidth < kCompact;
    if (compact && !this.compact) this.panel.element.hidden = this.plots.element.hidden = true;
    this.compact = compact;
    const box = this.view.getBoundingClientRect();
    if (box.width > 0 && box.height > 0) this.picture.stage.resize(box.width, box.height);
    this.picture.stage.draw(true);
  }

  togglePanel(): void {
    this.toggleSide(this.panel.element, this.plots.element);
  }
  togglePlots(): void {
    this.toggleSide(this.plots.element, this.panel.element);
    this.plots.draw();
  }
  private toggleSide(side: HTMLElement, other: HTMLElement) {
    side.hidden = !side.hidden;
    if (!side.hidden && this.compact) other.hidden = true;
  }
  toggleHelp(): void {
    if (this.help.open) this.help.close();
    else this.help.showModal();
  }
}
