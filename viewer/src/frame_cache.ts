/** Frames that have arrived or are on their way, the least recently used forgotten first. */
import type { Frame } from './run';

export class FrameCache {
  private readonly kept = new Map<number, Frame>(); // in order of use
  private readonly coming = new Map<number, Promise<Frame>>();
  private bytes = 0;

  /** @param limit [bytes] of frames kept; the one just asked for is kept whatever its size */
  constructor(
    private readonly load: (index: number) => Promise<Frame>,
    private readonly limit = 384 * 2 ** 20,
  ) {}

  /** The frame if it is here already. */
  peek(index: number): Frame | undefined {
    const frame = this.kept.get(index);
    if (frame) {
      this.kept.delete(index);
      this.kept.set(index, frame);
    }
    return frame;
  }

  get(index: number): Promise<Frame> {
    const here = this.peek(index);
    if (here) return Promise.resolve(here);
    const already = this.coming.get(index);
    if (already) return already;
    const promise = this.load(index).then(
      (frame) => {
        this.coming.delete(index);
        this.keep(frame);
        return frame;
      },
      (error: unknown) => {
        this.coming.delete(index);
        throw error;
      },
    );
    this.coming.set(index, promise);
    return promise;
  }

  /** Asks for the frames that playing will need next, a few at a time. */
  prefetch(indices: number[], atOnce = 4): void {
    for (const index of indices) {
      if (this.coming.size >= atOnce) return;
      if (!this.kept.has(index)) this.get(index).catch(() => undefined); // shown when it is asked for in earnest
    }
  }

  get size(): number {
    return this.kept.size;
  }

  private keep(frame: Frame) {
    this.kept.set(frame.index, frame);
    this.bytes += frame.bytes;
    for (const [index, old] of this.kept) {
      if (this.bytes <= this.limit || index === frame.index) break;
      this.kept.delete(index);
      this.bytes -= old.bytes;
    }
  }
}
