/** Follows a wish that changes: only the latest counts while an answer is on its way. */

/** What is wanted now: equal keys have equal answers. */
export interface Wish {
  key: string;
  /** Asks for it, and keeps the answer or tells why there is none. */
  ask(): Promise<void>;
}

export class Latest {
  private had = ''; // key of the last answer
  private asking: Promise<void> | undefined;

  /**
   * @param wish what is wanted, if anything
   * @param draw shows the last answer, or nothing if nothing is wanted
   */
  constructor(
    private readonly wish: () => Wish | undefined,
    private readonly draw: () => void,
  ) {}

  /** Asks until the answer is to what is wanted. */
  follow(): Promise<void> {
    if (!this.wish()) {
      this.draw();
      return Promise.resolve();
    }
    this.asking ??= this.ask();
    return this.asking;
  }

  private async ask() {
    await Promise.resolve(); // what ends at once must not end before it is kept
    try {
      for (let wish = this.wish(); wish && wish.key !== this.had; wish = this.wish()) {
        await wish.ask();
        this.had = wish.key;
        this.draw();
      }
    } finally {
      this.asking = undefined;
    }
    this.draw();
  }
}
