/** Keeps the slice through the densities in step with the frame shown and with the card that steers it. */
import { fetchSlice } from './client';
import { Latest, type Wish } from './latest';
import type { Picture } from './picture';
import type { RunInfo } from './run';
import type { Slice, SliceWish } from './slice';
import type { Panel } from './ui/panel';

/** A slice whose body is given by name. */
export interface NamedSlice {
  axis: number;
  at?: number;
  body?: string;
}

export class Slicing {
  private slice: Slice | undefined; // the last that came
  private readonly latest = new Latest(
    () => this.wish(),
    () => this.draw(),
  );

  constructor(
    private readonly picture: Picture,
    private readonly panel: Panel,
  ) {}

  /** Asks for the plane that is wanted until it is there. */
  refresh(): Promise<void> {
    return this.latest.follow();
  }

  private wish(): Wish | undefined {
    const card = this.panel.slice;
    const { shown } = this.picture;
    if (!card.on || !shown) return undefined;
    const { wish } = card;
    return {
      key: `${shown.index} ${JSON.stringify(wish)}`,
      ask: async () => {
        try {
          this.slice = await fetchSlice(shown.index, wish);
          card.show(this.slice);
        } catch (error) {
          this.slice = undefined;
          card.fail((error as Error).message);
        }
      },
    };
  }

  draw() {
    const card = this.panel.slice;
    const colours = this.panel.looks.map((l) => l.colour);
    this.picture.setSlice(card.on ? this.slice : undefined, colours, card.wish.body >= 0, card.cut);
  }

  /** Shows the densities on a plane; a body is given by name. For pictures. */
  async show(run: RunInfo | undefined, wish: NamedSlice): Promise<void> {
    const { body, ...rest } = wish;
    const known = run?.bodies.find((b) => b.name === body)?.index;
    if (body !== undefined && known === undefined) throw new Error(`no body is named "${body}"`);
    if (!run?.slices) throw new Error('this run keeps no scene to make densities from');
    const full: Partial<SliceWish> = body === undefined ? rest : { ...rest, body: known! };
    this.panel.slice.set(full);
    await this.refresh();
  }
}
