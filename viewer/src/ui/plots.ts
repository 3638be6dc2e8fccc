/** The plots beside the picture. Pointing at one shows its values there and marks the moment everywhere. */
import type { Player } from '../player';
import type { SensorInfo, Series } from '../run';
import { h, human } from './dom';
import { plotSpecs, roundUp, squeeze, type PlotSpec } from './plot_data';

const kLeft = 6;
const kRight = 6;
const kTop = 17; // room for the label of the largest value
const kBottom = 17; // and of the least

class Plot {
  readonly element: HTMLElement;
  private readonly canvas = h('canvas', { class: 'plot' });
  private readonly top = h('span', { class: 'top' });
  private readonly bottom = h('span', { class: 'bottom' });
  private readonly legend = h('div', { class: 'legend' });
  private still: HTMLCanvasElement | undefined; // the curves, drawn once per size and data

  constructor(
    private spec: PlotSpec,
    private readonly player: Player,
    onHover: (frame: number | undefined) => void,
  ) {
    this.canvas.addEventListener('pointermove', (e) => onHover(this.frameAt(e)));
    this.canvas.addEventListener('pointerleave', () => onHover(undefined));
    const seek = (e: PointerEvent) => player.step(this.frameAt(e) - player.frame);
    this.canvas.addEventListener('pointerdown', (e) => {
      this.canvas.setPointerCapture(e.pointerId);
      seek(e);
    });
    this.canvas.addEventListener('pointermove', (e) => {
      if (e.buttons & 1) seek(e);
    });
    this.element = h(
      'section',
      { class: 'card plotcard' },
      h('h3', {}, spec.title),
      h('div', { class: 'plotbox' }, this.canvas, this.top, this.bottom),
      this.legend,
    );
  }

  get title(): string {
    return this.spec.title;
  }

  setSpec(spec: PlotSpec) {
    this.spec = spec;
    this.still = undefined;
  }

  forgetSize() {
    this.still = undefined;
  }

  private frameAt(e: PointerEvent): number {
    const box = this.canvas.getBoundingClientRect();
    const share = (e.clientX - box.left - kLeft) / Math.max(1, box.width - kLeft - kRight);
    return Math.round(Math.max(0, Math.min(1, share)) * Math.max(0, this.player.frames - 1));
  }

  draw(hover: number | undefined) {
    const ratio = window.devicePixelRatio;
    const width = Math.round(this.canvas.clientWidth * ratio);
    const height = Math.round(this.canvas.clientHeight * ratio);
    if (width < 10 || height < 10) return;
    if (!this.still || this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
      this.still = document.createElement('canvas');
      this.still.width = width;
      this.still.height = height;
      this.drawCurves(this.still.getContext('2d')!, width, height, ratio);
    }
    const context = this.canvas.getContext('2d')!;
    context.clearRect(0, 0, width, height);
    context.drawImage(this.still, 0, 0);
    const line = (frame: number, colour: string) => {
      const x =
        ratio * kLeft + ((width - ratio * (kLeft + kRight)) * frame) / Math.max(1, this.player.frames - 1);
      context.fillStyle = colour;
      context.fillRect(Math.round(x - ratio / 2), 0, Math.max(1, Math.round(ratio)), height);
    };
    line(this.player.frame, '#1d2733');
    if (hover !== undefined) line(hover, 'rgba(29, 39, 51, 0.4)');
    this.drawLegend(hover ?? this.player.frame);
  }

  private drawLegend(frame: number) {
    const { curves, unit, kind } = this.spec;
    const value = (x: number | undefined) =>
      x === undefined ? '' : unit === 'voxels' ? `${human(x)} voxels` : human(x, unit);
    const items = curves.map((c) =>
      h('span', { class: 'item' }, swatch(c.colour), c.name, h('b', {}, value(c.values[frame]))),
    );
    if (kind === 'stack') {
      let sum = 0;
      for (const c of curves) sum += c.values[frame] ?? 0;
      items.push(h('span', { class: 'item total' }, 'all', h('b', {}, value(sum))));
    }
    this.legend.replaceChildren(...items);
  }

  private drawCurves(context: CanvasRenderingContext2D, width: number, height: number, ratio: number) {
    const { curves, kind, unit } = this.spec;
    const left = kLeft * ratio;
    const top = kTop * ratio;
    const w = width - (kLeft + kRight) * ratio;
    const depth = height - (kTop + kBottom) * ratio;
    const bins = Math.max(2, Math.floor(w / ratio));
    const squeezed = curves.map((c) => squeeze(c.values, bins, kind === 'stack' ? 'mean' : 'max'));
    const count = squeezed[0]?.length ?? 0;
    const x = (i: number) => left + (w * i) / Math.max(1, count - 1);

    let lo = 0;
    let hi = 1;
    const finite = squeezed.flatMap((s) => [...s]).filter((v) => Number.isFinite(v));
    if (kind === 'stack') {
      const sums = Array.from({ length: count }, (_, i) => squeezed.reduce((sum, s) => sum + (s[i] ?? 0), 0));
      hi = roundUp(Math.max(0, ...sums.filter(Number.isFinite)));
    } else if (kind === 'log') {
      const positive = finite.filter((v) => v > 0);
      hi = positive.length ? Math.ceil(Math.log10(Math.max(...positive)) + 1e-9) : 0;
      lo = positive.length ? Math.min(hi - 1, Math.floor(Math.log10(Math.min(...positive)))) : -1;
    } else {
      hi = roundUp(Math.max(0, ...finite));
      const least = Math.min(0, ...finite);
      lo = least < 0 ? -roundUp(-least) : 0;
    }
    const y = (v: number) =>
      top + depth * (1 - ((kind === 'log' ? Math.log10(Math.max(v, 1e-300)) : v) - lo) / (hi - lo));

    context.fillStyle = 'rgba(36, 56, 77, 0.12)';
    for (let k = 0; k <= 4; ++k)
      context.fillRect(left, Math.round(top + (depth * k) / 4), w, Math.max(1, ratio / 2));

    if (kind === 'stack') {
      const base = new Float64Array(count);
      squeezed.forEach((s, c) => {
        context.beginPath();
        for (let i = 0; i < count; ++i) context.lineTo(x(i), y(base[i]!));
        for (let i = count - 1; i >= 0; --i) context.lineTo(x(i), y(base[i]! + (s[i] || 0)));
        context.closePath();
        context.fillStyle = curves[c]!.colour;
        context.fill();
        for (let i = 0; i < count; ++i) base[i]! += s[i] || 0;
      });
    } else {
      squeezed.forEach((s, c) => {
        context.beginPath();
        let pen = false;
        for (let i = 0; i < count; ++i) {
          const v = s[i]!;
          if (!Number.isFinite(v) || (kind === 'log' && v <= 0)) pen = false;
          else if (pen) context.lineTo(x(i), y(v));
          else {
            context.moveTo(x(i), y(v));
            pen = true;
          }
        }
        context.lineWidth = 1.6 * ratio;
        context.lineJoin = 'round';
        context.strokeStyle = curves[c]!.colour;
        context.stroke();
      });
    }
    const label = (v: number) =>
      kind === 'log' ? `1e${v}`.replace('-', '−') : unit === 'voxels' ? human(v) : human(v, unit);
    this.top.textContent = label(hi);
    this.bottom.textContent = label(lo);
  }
}

export function swatch(colour: string): HTMLElement {
  const box = h('i', { class: 'swatch' });
  box.style.background = colour;
  return box;
}

export class Plots {
  readonly element = h('aside', { class: 'side right', 'aria-label': 'plots' });
  private plots: Plot[] = [];
  private hovered: number | undefined;

  constructor(
    private readonly player: Player,
    private readonly onHover: (frame: number | undefined) => void,
  ) {
    player.onChange(() => this.draw());
    new ResizeObserver(() => {
      for (const p of this.plots) p.forgetSize();
      this.draw();
    }).observe(this.element);
  }

  setSeries(series: Series, sensors: SensorInfo[] = []): void {
    const specs = plotSpecs(series, sensors);
    const same =
      specs.length === this.plots.length && specs.every((s, i) => s.title === this.plots[i]!.title);
    if (same) specs.forEach((s, i) => this.plots[i]!.setSpec(s));
    else {
      this.plots = specs.map((s) => new Plot(s, this.player, this.onHover));
      this.element.replaceChildren(...this.plots.map((p) => p.element));
    }
    if (!specs.length)
      this.element.replaceChildren(h('p', { class: 'empty' }, 'This run has recorded no series.'));
    this.draw();
  }

  hover(frame: number | undefined): void {
    this.hovered = frame;
    this.draw();
  }

  draw(): void {
    if (this.element.hidden) return;
    for (const p of this.plots) p.draw(this.hovered);
  }
}
