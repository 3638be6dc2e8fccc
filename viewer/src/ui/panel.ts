/** The side panel: bodies, contacts, attachments, tiles, touching pairs, warnings. */
import type { Player } from '../player';
import type { BodyLook } from '../picture';
import type { BodyInfo, Frame, RunInfo } from '../run';
import { overlapStops } from '../slice';
import {
  deepOverlap,
  frictionColour,
  nearColour,
  normalColour,
  type ContactStyle,
} from '../scene/contact_view';
import { linkColour } from '../scene/link_view';
import { h, human, iconButton, setIcon } from './dom';
import { swatch } from './plots';
import { SliceCard } from './slice_card';
import { StressCard } from './stress_card';
import { elasticKinds } from '../stress';

export interface PanelEvents {
  look(body: number, look: BodyLook): void;
  contacts(style: ContactStyle, scale: number): void;
  tiles(on: boolean): void;
  links(on: boolean): void;
  slice(): void;
  stress(): void;
  middle(): [number, number, number]; // [m] of what is shown
}

const kReadable = 200; // [ms] between two fillings of the table while the run plays

const styles: [ContactStyle, string][] = [
  ['off', 'off'],
  ['points', 'points'],
  ['forces', 'arrows'],
  ['all', 'both'],
  ['voxels', 'voxels'],
];

export class Panel {
  readonly element = h('aside', { class: 'side left', 'aria-label': 'what is shown' });
  looks: BodyLook[] = [];
  contactStyle: ContactStyle = 'off';
  contactScale = 1;
  tilesShown = false;
  linksShown = true;
  readonly slice: SliceCard;
  readonly stress: StressCard;
  private readonly status = h('p', { class: 'status' });
  private readonly bodies = h('ul', { class: 'bodies' });
  private readonly pairs = h('div', { class: 'pairs' });
  private readonly warnings = h('section', { class: 'card' });
  private readonly segments: HTMLButtonElement[];
  private readonly tilesBox = h('input', { type: 'checkbox', id: 'tiles' });
  private readonly linksBox = h('input', { type: 'checkbox', id: 'links', checked: true });
  private readonly links = h(
    'section',
    { class: 'card', hidden: true },
    h('h3', {}, 'Attachments'),
    h(
      'div',
      { class: 'row' },
      this.linksBox,
      h('label', { for: 'links' }, swatch(linkColour), ' what holds bodies: ends, ropes, axes'),
    ),
  );
  private readonly voxelLegend = h(
    'div',
    { class: 'legend', hidden: true },
    ...[
      [nearColour, 'near'],
      [overlapStops[0]!, 'touching'],
      [overlapStops[2]!, `${deepOverlap} voxels deep or more`],
    ].map(([colour, text]) => h('span', { class: 'item' }, swatch(colour!), text)),
  );
  private rows: { refresh(): void }[] = [];
  private run: RunInfo | undefined;
  private latest: Frame | undefined; // frame shown
  private tabled: Frame | undefined; // frame whose pairs the table has
  private tabledAt = 0; // [ms]

  constructor(
    private readonly player: Player,
    private readonly on: PanelEvents,
  ) {
    this.slice = new SliceCard(
      () => this.on.slice(),
      () => this.on.middle(),
    );
    this.stress = new StressCard(() => this.on.stress());
    this.segments = styles.map(([style, label]) =>
      h('button', { type: 'button', 'data-style': style, onclick: () => this.setContacts(style) }, label),
    );
    const slider = h('input', { type: 'range', min: '-1', max: '1', step: '0.02', value: '0', id: 'arrow' });
    slider.addEventListener('input', () => {
      this.contactScale = 10 ** Number(slider.value);
      this.on.contacts(this.contactStyle, this.contactScale);
    });
    this.tilesBox.addEventListener('change', () => this.setTiles(this.tilesBox.checked));
    this.linksBox.addEventListener('change', () => this.setLinks(this.linksBox.checked));
    this.element.append(
      h('section', { class: 'card head' }, this.status),
      h(
        'section',
        { class: 'card' },
        h(
          'h3',
          {},
          'Bodies',
          h('span', { class: 'spacer' }),
          h('button', { class: 'text', type: 'button', onclick: () => this.showAll(true) }, 'all'),
          h('button', { class: 'text', type: 'button', onclick: () => this.showAll(false) }, 'none'),
        ),
        this.bodies,
      ),
      h(
        'section',
        { class: 'card' },
        h('h3', {}, 'Contacts'),
        h('div', { class: 'segments', role: 'group', 'aria-label': 'contacts' }, ...this.segments),
        h('div', { class: 'row' }, h('label', { for: 'arrow' }, 'arrow length'), slider),
        h(
          'div',
          { class: 'legend' },
          h('span', { class: 'item' }, swatch(normalColour), 'normal force'),
          h('span', { class: 'item' }, swatch(frictionColour), 'friction'),
        ),
        this.voxelLegend,
        this.pairs,
      ),
      this.links,
      this.stress.element,
      this.slice.element,
      h(
        'section',
        { class: 'card' },
        h('h3', {}, 'Grid'),
        h(
          'div',
          { class: 'row' },
          this.tilesBox,
          h('label', { for: 'tiles' }, 'active tiles (8³ nodes each)'),
        ),
      ),
      this.warnings,
    );
    this.refreshContacts();
    player.onChange(() => {
      if (!player.playing && this.latest && this.latest !== this.tabled) this.fillTable(this.latest);
    });
  }

  /** Fills the panel; what the user chose for bodies shown before is kept. */
  setRun(run: RunInfo, colours: string[]): void {
    this.run = run;
    const fresh = this.looks.length !== run.bodies.length;
    if (fresh) {
      this.looks = colours.map((colour) => ({
        visible: true,
        colour,
        wireframe: false,
        surface: false,
      }));
      this.rows = [];
      this.bodies.replaceChildren(...run.bodies.map((b) => this.bodyRow(b)));
    }
    this.status.replaceChildren(
      h('b', { class: 'name' }, run.name),
      h(
        'span',
        {},
        `${run.bodies.length} ${run.bodies.length === 1 ? 'body' : 'bodies'} · ${run.frames} frames · `,
      ),
      h(
        'span',
        {
          class: run.stopped ? 'stopped' : run.complete ? '' : 'growing',
          title: run.stopped ? 'the program that wrote it is gone; brim run --resume goes on with it' : '',
        },
        run.stopped ? 'cut short' : run.complete ? 'complete' : 'growing',
      ),
      ...(run.interactive && !run.complete ? [h('span', { class: 'hint' }, 'drag a body to pull it')] : []),
    );
    this.links.hidden = !run.links?.length;
    this.stress.setRun(run.slices === true && run.bodies.some((b) => elasticKinds.includes(b.kind)));
    this.warnings.hidden = run.warnings.length === 0;
    this.warnings.replaceChildren(
      h('h3', {}, `Warnings (${run.warnings.length})`),
      h(
        'ul',
        { class: 'warnings' },
        ...run.warnings.slice(0, 100).map((w) =>
          h(
            'li',
            {},
            h(
              'button',
              {
                type: 'button',
                class: 'warning',
                onclick: () => this.player.step(this.player.frameAt(w.time) - this.player.frame),
              },
              h('b', {}, `${human(w.time, 's')} · ${w.code.replaceAll('_', ' ')}`),
              h('span', {}, w.message),
            ),
          ),
        ),
      ),
    );
  }

  private bodyRow(body: BodyInfo): HTMLElement {
    const look = () => this.looks[body.index]!;
    const tell = () => {
      refresh();
      this.on.look(body.index, look());
    };
    const eye = iconButton('eye', 'hide', () => {
      look().visible = !look().visible;
      tell();
    });
    const wire = iconButton('wire', `wireframe of ${body.name}`, () => {
      look().wireframe = !look().wireframe;
      tell();
    });
    const surface = iconButton('drop', `surface around the particles of ${body.name}`, () => {
      look().surface = !look().surface;
      tell();
    });
    const colour = h('input', {
      type: 'color',
      value: look().colour,
      'aria-label': `colour of ${body.name}`,
      title: 'colour',
    });
    colour.addEventListener('input', () => {
      look().colour = colour.value;
      tell();
    });
    const row = h(
      'li',
      { 'data-body': body.index },
      colour,
      h(
        'span',
        { class: 'what' },
        h('b', {}, body.name),
        h(
          'small',
          {},
          body.fixed || body.changing
            ? `${body.kind}`
            : `${body.kind} · ${body.vertices.toLocaleString('en')} points`,
        ),
      ),
      ...(body.display === 'points' ? [surface] : []),
      wire,
      eye,
    );
    const refresh = () => {
      colour.value = look().colour;
      row.classList.toggle('off', !look().visible);
      wire.classList.toggle('on', look().wireframe);
      wire.setAttribute('aria-pressed', String(look().wireframe));
      surface.classList.toggle('on', look().surface);
      surface.setAttribute('aria-pressed', String(look().surface));
      setIcon(eye, look().visible ? 'eye' : 'hidden', `${look().visible ? 'hide' : 'show'} ${body.name}`);
    };
    refresh();
    this.rows.push({ refresh });
    return row;
  }

  private changeAll(change: (look: BodyLook) => void) {
    this.looks.forEach((look, body) => {
      change(look);
      this.rows[body]?.refresh();
      this.on.look(body, look);
    });
  }

  showAll(visible: boolean): void {
    this.changeAll((look) => (look.visible = visible));
  }

  /** The bodies of a name and their numbered copies: "gear" means gear, gear.2 and so on. */
  private named(name: string): BodyInfo[] {
    const bodies = (this.run?.bodies ?? []).filter(
      (b) =>
        b.name === name || (b.name.startsWith(`${name}.`) && /^\d+$/.test(b.name.slice(name.length + 1))),
    );
    if (bodies.length === 0) throw new Error(`no body is named "${name}"`);
    return bodies;
  }

  private change(body: number, look: Partial<BodyLook>) {
    Object.assign(this.looks[body]!, look);
    this.rows[body]?.refresh();
    this.on.look(body, this.looks[body]!);
  }

  /** Shows particles as the surface around them: of the bodies of these names, or of all. */
  setSurfaces(names: string[] | 'all'): void {
    const bodies = names === 'all' ? (this.run?.bodies ?? []) : names.flatMap((name) => this.named(name));
    const particles = bodies.filter((b) => b.display === 'points');
    if (names !== 'all' && particles.length < bodies.length)
      throw new Error(`"${bodies.find((b) => b.display !== 'points')!.name}" is not made of particles`);
    for (const b of particles) this.change(b.index, { surface: true });
  }

  /** @param colours name of bodies -> #rrggbb */
  setColours(colours: Record<string, string>): void {
    for (const [name, colour] of Object.entries(colours))
      for (const b of this.named(name)) this.change(b.index, { colour });
  }

  /** Wireframe for all bodies, or for none if all have it. */
  toggleWireframe(): void {
    const on = !this.looks.every((l) => l.wireframe);
    this.changeAll((look) => (look.wireframe = on));
  }

  setContacts(style: ContactStyle): void {
    this.contactStyle = style;
    this.refreshContacts();
    this.on.contacts(style, this.contactScale);
  }

  /** Goes through off, points, arrows, both, voxels. */
  cycleContacts(): void {
    const at = styles.findIndex(([s]) => s === this.contactStyle);
    this.setContacts(styles[(at + 1) % styles.length]![0]);
  }

  setTiles(on: boolean): void {
    this.tilesShown = on;
    this.tilesBox.checked = on;
    this.on.tiles(on);
  }

  setLinks(on: boolean): void {
    this.linksShown = on;
    this.linksBox.checked = on;
    this.on.links(on);
  }

  private refreshContacts() {
    this.voxelLegend.hidden = this.contactStyle !== 'voxels';
    for (const s of this.segments) {
      const on = s.dataset.style === this.contactStyle;
      s.classList.toggle('on', on);
      s.setAttribute('aria-pressed', String(on));
    }
  }

  /** The table of touching pairs of the frame shown; while playing no oftener than can be read. */
  showFrame(frame: Frame): void {
    this.latest = frame;
    if (this.player.playing && performance.now() - this.tabledAt < kReadable) return;
    this.fillTable(frame);
  }

  private fillTable(frame: Frame) {
    this.tabled = frame;
    this.tabledAt = performance.now();
    const totals = frame.pairs;
    if (!totals.length) {
      this.pairs.replaceChildren(h('p', { class: 'empty' }, 'Nothing touches in this frame.'));
      return;
    }
    const name = (part: number) => this.run?.parts[part]?.name ?? `part ${part}`;
    this.pairs.replaceChildren(
      h(
        'table',
        {},
        h(
          'thead',
          {},
          h('tr', {}, ...['pair', 'nodes', 'normal', 'friction', 'voxels'].map((t) => h('th', {}, t))),
        ),
        h(
          'tbody',
          {},
          ...totals
            .slice(0, 200)
            .map((t) =>
              h(
                'tr',
                {},
                h(
                  'td',
                  { title: `${name(t.a)} and ${name(t.b)}` },
                  h('div', {}, name(t.a)),
                  h('div', {}, name(t.b)),
                ),
                h('td', {}, String(t.count)),
                h('td', {}, human(t.normal, 'N')),
                h('td', {}, human(t.friction, 'N')),
                h(
                  'td',
                  { title: `worst overlap in voxels; pressure ${human(t.pressure)} of the stiffness` },
                  human(t.worstOverlap),
                ),
              ),
            ),
        ),
      ),
      ...(totals.length > 200 ? [h('p', { class: 'empty' }, `and ${totals.length - 200} more pairs`)] : []),
    );
  }
}

const keys: [string, string][] = [
  ['space', 'play or pause'],
  ['← →', 'one frame back or on (shift: ten)'],
  ['home, end', 'first or last frame'],
  ['f', 'fit the view to what is shown'],
  ['1 2 3', 'view from the front, the side, above'],
  ['w', 'wireframe'],
  ['c', 'contacts: off, points, arrows, both, voxels'],
  ['t', 'active tiles'],
  ['a', 'attachments and joints'],
  ['d', 'slice through the densities'],
  ['m', 'stress of elastic solids'],
  ['x y z', 'across which axis'],
  ['l', 'loop'],
  ['p', 'plots'],
  ['b', 'bodies'],
  ['s', 'save a picture'],
  ['?', 'this list'],
];

export function helpDialog(): HTMLDialogElement {
  const dialog = h(
    'dialog',
    { class: 'help', 'aria-label': 'keys' },
    h('h2', {}, 'Keys'),
    h(
      'dl',
      {},
      ...keys.flatMap(([k, v]) => [
        h('dt', {}, ...k.split(' ').map((x) => h('kbd', {}, x.replace(',', '')))),
        h('dd', {}, v),
      ]),
    ),
    h(
      'p',
      {},
      'Drag to turn, drag with the right button to move, scroll to come closer. Click a body or a contact to read its numbers. In a run that is made with --interactive, drag a body to pull it; with shift the drag turns the view.',
    ),
    h('button', { type: 'button', class: 'wide', onclick: () => dialog.close() }, 'Close'),
  );
  dialog.addEventListener('click', (e) => {
    if (e.target === dialog) dialog.close();
  });
  return dialog;
}
