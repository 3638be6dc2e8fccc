/** The bar below the picture: transport buttons, the scrubber with marks for warnings, time, speed, loop. */
import type { Player } from '../player';
import type { Warning } from '../run';
import { h, human, iconButton, setIcon } from './dom';

const speeds = [0.05, 0.1, 0.25, 0.5, 1, 2, 4];

export class Timeline {
  readonly element: HTMLElement;
  private readonly play: HTMLButtonElement;
  private readonly loop: HTMLButtonElement;
  private readonly range = h('input', {
    type: 'range',
    class: 'scrub',
    min: '0',
    max: '0',
    step: '1',
    value: '0',
    'aria-label': 'frame',
  });
  private readonly marks = h('div', { class: 'marks' });
  private readonly ghost = h('div', { class: 'ghost', hidden: true });
  private readonly clock = h('output', { class: 'clock', 'aria-live': 'off' });
  private readonly speed = h(
    'select',
    { 'aria-label': 'speed', title: 'speed' },
    ...speeds.map((s) => h('option', { value: String(s) }, `${s}×`)),
  );

  constructor(
    private readonly player: Player,
    private readonly onHover: (frame: number | undefined) => void,
  ) {
    this.play = iconButton('play', 'play (space)', () => player.toggle(), { class: 'icon primary' });
    this.loop = iconButton('loop', 'start over at the end', () => player.setLoop(!player.loop));
    this.range.addEventListener('input', () => {
      player.playing = false;
      player.seek(Number(this.range.value));
    });
    this.range.addEventListener('pointermove', (e) => this.onHover(this.frameAt(e.clientX)));
    this.range.addEventListener('pointerleave', () => this.onHover(undefined));
    this.speed.addEventListener('change', () => player.setSpeed(Number(this.speed.value)));
    this.element = h(
      'footer',
      { class: 'timeline' },
      h(
        'div',
        { class: 'transport' },
        iconButton('first', 'first frame (home)', () => player.step(-player.frames)),
        iconButton('back', 'one frame back (left arrow)', () => player.step(-1)),
        this.play,
        iconButton('forward', 'one frame on (right arrow)', () => player.step(1)),
        iconButton('last', 'last frame (end)', () => player.step(player.frames)),
      ),
      h('div', { class: 'track' }, this.marks, this.range, this.ghost),
      this.clock,
      this.speed,
      this.loop,
    );
    player.onChange(() => this.refresh());
    this.refresh();
  }

  private frameAt(x: number): number {
    const box = this.range.getBoundingClientRect();
    const share = (x - box.left - 7) / Math.max(1, box.width - 14);
    return Math.round(Math.max(0, Math.min(1, share)) * Math.max(0, this.player.frames - 1));
  }

  private place(frame: number): string {
    const share = frame / Math.max(1, this.player.frames - 1);
    return `calc(7px + (100% - 14px) * ${share})`;
  }

  showWarnings(warnings: Warning[]): void {
    this.marks.replaceChildren(
      ...warnings.slice(0, 500).map((w) => {
        const frame = this.player.frameAt(w.time);
        const label = `${human(w.time, 's')}: ${w.code.replaceAll('_', ' ')}. ${w.message}`;
        const mark = h('button', {
          class: 'mark',
          type: 'button',
          title: label,
          'aria-label': label,
          onclick: () => this.player.step(frame - this.player.frame),
        });
        mark.style.left = this.place(frame);
        return mark;
      }),
    );
  }

  /** A faint line at the moment that is pointed at elsewhere. */
  hover(frame: number | undefined): void {
    this.ghost.hidden = frame === undefined;
    if (frame !== undefined) this.ghost.style.left = this.place(frame);
  }

  refresh(): void {
    const { player } = this;
    setIcon(this.play, player.playing ? 'pause' : 'play', player.playing ? 'pause (space)' : 'play (space)');
    this.loop.classList.toggle('on', player.loop);
    this.loop.setAttribute('aria-pressed', String(player.loop));
    this.range.max = String(Math.max(0, player.frames - 1));
    this.range.value = String(player.frame);
    this.range.disabled = player.frames < 2;
    const share = player.frames > 1 ? player.frame / (player.frames - 1) : 0;
    this.range.style.setProperty('--done', `${100 * share}%`);
    this.speed.value = String(player.speed);
    this.clock.replaceChildren(
      h('b', {}, `${player.time().toFixed(3)} s`),
      h('span', {}, player.frames ? `${player.frame + 1} / ${player.frames}` : 'no frames'),
    );
  }
}
