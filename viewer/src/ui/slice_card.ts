/** The card that steers the slice through the densities. */
import type { BodyInfo } from '../run';
import { densityStops, overlapStops, worstOverlap, type Slice, type SliceWish } from '../slice';
import { h, human } from './dom';

const axes = ['x', 'y', 'z'];
const gradient = (stops: readonly string[]) => `background: linear-gradient(90deg, ${stops.join(', ')})`;

export class SliceCard {
  readonly element: HTMLElement;
  on = false;
  cut = true; // bodies are cut open where the plane is
  wish: SliceWish = { axis: 1, at: 0, body: -1 };
  private readonly box = h('input', { type: 'checkbox', id: 'slice' });
  private readonly cutBox = h('input', { type: 'checkbox', id: 'slice-cut', checked: true });
  private readonly place = h('input', {
    type: 'range',
    min: '0',
    max: '1',
    step: 'any',
    value: '0.5',
    'aria-label': 'place of the slice',
  });
  private readonly who = h('select', { 'aria-label': 'whose densities' });
  private readonly axisButtons: HTMLButtonElement[];
  private readonly density = h('div', { class: 'ramp' });
  private readonly worst = h('span', {}, 'overlap');
  private readonly facts = h('p', { class: 'facts', 'aria-live': 'off' });
  private readonly controls: HTMLElement;
  private range: [number, number] = [0, 1];
  private placed = false; // by hand; otherwise the slice starts where something is

  /**
   * @param change called when another plane is wanted, or none
   * @param middle [m] of what is shown: where a slice starts
   */
  constructor(
    private readonly change: () => void,
    private readonly middle: () => [number, number, number],
  ) {
    this.axisButtons = axes.map((name, axis) =>
      h('button', { type: 'button', 'data-axis': axis, onclick: () => this.setAxis(axis) }, name),
    );
    this.box.addEventListener('change', () => this.setOn(this.box.checked));
    this.cutBox.addEventListener('change', () => {
      this.cut = this.cutBox.checked;
      this.change();
    });
    this.place.addEventListener('input', () => {
      const [low, high] = this.range;
      this.wish = { ...this.wish, at: low + Number(this.place.value) * (high - low) };
      this.placed = true;
      this.change();
    });
    this.who.addEventListener('change', () => {
      this.wish = { ...this.wish, body: Number(this.who.value) };
      this.refresh();
      this.change();
    });
    this.controls = h(
      'div',
      { hidden: true },
      h(
        'div',
        { class: 'row' },
        h('div', { class: 'segments narrow', role: 'group', 'aria-label': 'axis' }, ...this.axisButtons),
        this.place,
      ),
      h('div', { class: 'row' }, this.who),
      h('div', { class: 'row' }, this.cutBox, h('label', { for: 'slice-cut' }, 'cut the bodies open')),
      h('div', { class: 'scale' }, this.density, h('span', {}, 'empty'), h('span', {}, 'full')),
      h(
        'div',
        { class: 'scale' },
        h('div', { class: 'ramp', style: gradient(overlapStops) }),
        h('span', {}, 'touching'),
        this.worst,
      ),
      this.facts,
    );
    this.element = h(
      'section',
      { class: 'card slice' },
      h('h3', {}, 'Densities'),
      h('div', { class: 'row' }, this.box, h('label', { for: 'slice' }, 'slice through the grid')),
      this.controls,
    );
    this.refresh();
  }

  setRun(bodies: BodyInfo[], possible: boolean): void {
    this.element.hidden = !possible;
    if (this.who.options.length === bodies.length + 1) return;
    this.who.replaceChildren(
      h('option', { value: '-1' }, 'all bodies, in their colours'),
      ...bodies.map((b) => h('option', { value: String(b.index) }, b.name)),
    );
  }
  setOn(on: boolean): void {
    if (on && !this.on && !this.placed) this.wish = { ...this.wish, at: this.middle()[this.wish.axis]! };
    this.on = on;
    this.box.checked = on;
    this.refresh();
    this.change();
  }

  setAxis(axis: number): void {
    this.wish = { ...this.wish, axis, at: this.middle()[axis]! };
    this.placed = false;
    this.refresh();
    this.change();
  }

  set(wish: Partial<SliceWish>): void {
    const axis = wish.axis ?? this.wish.axis;
    this.wish = { axis, at: this.middle()[axis]!, body: this.wish.body, ...wish };
    this.placed = wish.at !== undefined;
    this.who.value = String(this.wish.body);
    this.setOn(true);
  }

  private refresh(): void {
    this.controls.hidden = !this.on;
    this.axisButtons.forEach((b, axis) => {
      b.classList.toggle('on', axis === this.wish.axis);
      b.setAttribute('aria-pressed', String(axis === this.wish.axis));
    });
    this.density.setAttribute(
      'style',
      this.wish.body >= 0 ? gradient(densityStops) : gradient(['#f7f4ee', '#7d8894']),
    );
  }

  /** Tells what the plane shows. */
  show(slice: Slice): void {
    this.range = [slice.lowest, slice.highest];
    const span = slice.highest - slice.lowest;
    if (document.activeElement !== this.place && span > 0)
      this.place.value = String((slice.at - slice.lowest) / span);
    const worst = worstOverlap(slice);
    this.worst.textContent = worst > 0 ? `deepest, ${human(worst)}` : 'nothing overlaps here';
    this.facts.className = 'facts';
    this.facts.textContent = `${axes[slice.axis]} = ${slice.at.toFixed(3)} m · voxels of ${human(slice.step, 'm')} · ${slice.count[0]} × ${slice.count[1]} nodes`;
  }

  fail(message: string): void {
    this.facts.className = 'facts bad';
    this.facts.textContent = message;
  }
}
