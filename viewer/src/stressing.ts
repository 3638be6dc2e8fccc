/** Keeps the colours of stress in step with the frame shown and with the card that steers them. */
import { fetchStress } from './client';
import { Latest, type Wish } from './latest';
import type { Picture } from './picture';
import type { RunInfo } from './run';
import { largest, type Stress } from './stress';
import type { StressCard } from './ui/stress_card';

export class Stressing {
  private stress: Stress | undefined; // the last that came
  private readonly latest = new Latest(
    () => this.wish(),
    () => this.draw(),
  );

  constructor(
    private readonly picture: Picture,
    private readonly card: StressCard,
  ) {}

  /** Asks for the stress of the frame shown until it is there. */
  refresh(): Promise<void> {
    return this.latest.follow();
  }

  private wish(): Wish | undefined {
    const index = this.picture.shown?.index;
    if (!this.card.on || index === undefined) return undefined;
    return {
      key: `${index}`,
      ask: async () => {
        try {
          this.stress = await fetchStress(index);
        } catch (error) {
          this.stress = undefined;
          this.card.fail((error as Error).message);
        }
      },
    };
  }

  draw() {
    const { card, stress } = this;
    if (card.on && stress) card.show(largest(stress), stress.size);
    this.picture.setStress(card.on ? stress : undefined, card.top);
  }

  /** Shows it. @param top [Pa] of the last colour; 0: the largest of each frame */
  async show(run: RunInfo | undefined, top: number): Promise<void> {
    if (!run?.slices) throw new Error('this run keeps no scene to find stress from');
    this.card.set(top);
    await this.refresh();
    if (this.stress?.size === 0) throw new Error('this run has no elastic solid');
  }
}
