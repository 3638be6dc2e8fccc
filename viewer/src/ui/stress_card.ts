/** The card that steers the colours of stress. */
import { stressStops } from '../stress';
import { h, human } from './dom';

export class StressCard {
  readonly element: HTMLElement;
  on = false;
  private given = 0; // [Pa] of the last colour, as asked for; 0: the largest of the frame
  private most = 0; // [Pa] of the frame shown
  private readonly box = h('input', { type: 'checkbox', id: 'stress' });
  private readonly limit = h('input', {
    type: 'number',
    min: '0',
    step: 'any',
    id: 'stress-top',
    placeholder: 'largest of the frame',
    'aria-label': 'stress of the last colour, Pa',
  });
  private readonly end = h('span', {}, '');
  private readonly facts = h('p', { class: 'facts', 'aria-live': 'off' });
  private readonly controls: HTMLElement;

  /** @param change called when it is wanted or not, or with another scale */
  constructor(private readonly change: () => void) {
    this.box.addEventListener('change', () => this.setOn(this.box.checked));
    this.limit.addEventListener('input', () => {
      this.given = Math.max(0, Number(this.limit.value) || 0);
      this.change();
    });
    this.controls = h(
      'div',
      { hidden: true },
      h('div', { class: 'row' }, h('label', { for: 'stress-top' }, 'up to [Pa]'), this.limit),
      h(
        'div',
        { class: 'scale' },
        h('div', { class: 'ramp', style: `background: linear-gradient(90deg, ${stressStops.join(', ')})` }),
        h('span', {}, '0'),
        this.end,
      ),
      this.facts,
    );
    this.element = h(
      'section',
      { class: 'card stress', hidden: true },
      h('h3', {}, 'Stress'),
      h(
        'div',
        { class: 'row' },
        this.box,
        h('label', { for: 'stress' }, 'von Mises stress of elastic solids'),
      ),
      this.controls,
    );
  }

  setRun(possible: boolean): void {
    this.element.hidden = !possible;
  }

  setOn(on: boolean): void {
    this.on = on && !this.element.hidden;
    this.box.checked = this.on;
    this.controls.hidden = !this.on;
    this.change();
  }

  set(top: number): void {
    this.given = top;
    this.limit.value = top > 0 ? String(top) : '';
    this.setOn(true);
  }

  /** [Pa] of the last colour. */
  get top(): number {
    return this.given > 0 ? this.given : this.most;
  }

  /** Tells what the frame has. @param most [Pa] */
  show(most: number, solids: number): void {
    this.most = most;
    this.end.textContent = human(this.top, 'Pa');
    this.facts.className = 'facts';
    this.facts.textContent =
      solids > 0
        ? `largest on a surface now: ${human(most, 'Pa')}`
        : 'no body of this run is an elastic solid';
  }

  fail(message: string): void {
    this.facts.className = 'facts bad';
    this.facts.textContent = message;
  }
}
