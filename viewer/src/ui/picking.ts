/** A click on a body or a contact reads its numbers. */
import type { Picture } from '../picture';
import type { RunInfo } from '../run';
import { h, human } from './dom';

/** What was clicked, in numbers. */
class PickCard {
  readonly element = h('section', { class: 'pick card', hidden: true, 'aria-live': 'polite' });

  show(title: string, rows: [string, string][], ...actions: HTMLElement[]): void {
    this.element.hidden = false;
    this.element.replaceChildren(
      h(
        'h3',
        {},
        title,
        h('span', { class: 'spacer' }),
        h(
          'button',
          { class: 'text', type: 'button', 'aria-label': 'close', onclick: () => this.hide() },
          '×',
        ),
      ),
      h('dl', {}, ...rows.flatMap(([k, v]) => [h('dt', {}, k), h('dd', {}, v)])),
      ...actions,
    );
  }

  hide(): void {
    this.element.hidden = true;
  }
}

export class Picking {
  private readonly card = new PickCard();
  readonly element = this.card.element;

  /** @param run the run that the picture shows, once it is known */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly picture: Picture,
    private readonly run: () => RunInfo | undefined,
  ) {
    this.bind();
  }

  /** A click that is not a drag picks what is under it. */
  private bind() {
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
    const part = (p: number) => this.run()?.parts[p];
    return (this.picture.shown?.pairs ?? [])
      .filter((t) => (part(t.a)?.body === body) !== (part(t.b)?.body === body))
      .sort((s, t) => t.normal - s.normal)
      .slice(0, 6)
      .map((t) => [
        'touches',
        `${part(part(t.a)?.body === body ? t.b : t.a)?.name ?? '?'}, ${human(t.normal, 'N')}`,
      ]);
  }

  /** Lets the view go with a body, and stay where it is again. */
  private followButton(body: number): HTMLElement {
    const button = h('button', { class: 'text follow', type: 'button' });
    const label = () =>
      (button.textContent = this.picture.following === body ? 'stop following' : 'follow this body');
    button.addEventListener('click', () =>
      this.picture.follow(this.picture.following === body ? undefined : body),
    );
    this.picture.followChanged = label;
    label();
    return button;
  }

  pickAt(x: number, y: number): void {
    const picked = this.picture.pick(x, y);
    const point = (p: ArrayLike<number>) => [0, 1, 2].map((k) => (p[k] ?? 0).toFixed(4)).join(', ') + ' m';
    if (!picked) return this.card.hide();
    if (picked.contact !== undefined && this.picture.shown) {
      const c = this.picture.shown.contacts;
      const i = picked.contact;
      const name = (part: number) => this.run()?.parts[part]?.name ?? `part ${part}`;
      const size = (v: Float32Array) =>
        human(Math.hypot(v[3 * i] ?? 0, v[3 * i + 1] ?? 0, v[3 * i + 2] ?? 0), 'N');
      this.card.show('Contact', [
        ['between', `${name(c.pair[2 * i]!)} and ${name(c.pair[2 * i + 1]!)}`],
        ['at', point(c.position.subarray(3 * i, 3 * i + 3))],
        ['normal force', size(c.force)],
        ['friction', size(c.friction)],
        ['overlap', `${human(c.overlap[i] ?? 0)} voxels`],
      ]);
    } else if (picked.body) {
      const at = this.picture.positionOf(picked.body.index, picked.vertex ?? -1);
      const rows: [string, string][] = [
        ['kind', picked.body.kind],
        ['clicked at', point([picked.at.x, picked.at.y, picked.at.z])],
        ['nearest point', `number ${picked.vertex}`],
        ...(at ? [['lies at', point(at)] as [string, string]] : []),
        ['points', this.picture.pointsOf(picked.body.index).toLocaleString('en')],
        ...this.touching(picked.body.index),
      ];
      const moves = !picked.body.fixed;
      this.card.show(picked.body.name, rows, ...(moves ? [this.followButton(picked.body.index)] : []));
    }
  }
}
