/** Asks a worker for the surface of particles: of the latest ones only, where they come faster than it is done. */

export interface ShadedSurface {
  positions: Float32Array;
  cells: Uint32Array;
  normals: Float32Array;
}

export class Surfacer {
  private readonly worker: Worker;
  private wish: Float32Array | undefined;
  private busy = false;
  private waiting: (() => void)[] = [];

  /** @param done takes each surface @param radius [m] of the particles */
  constructor(
    private readonly radius: number,
    done: (surface: ShadedSurface) => void,
  ) {
    this.worker = new Worker(new URL('./surface_worker.ts', import.meta.url), { type: 'module' });
    this.worker.onmessage = (event: MessageEvent<ShadedSurface>) => {
      done(event.data);
      this.busy = false;
      this.next();
    };
    this.worker.onerror = () => {
      this.busy = false; // the balls stay
      this.next();
    };
  }

  /** @param points (n, 3); copied */
  ask(points: Float32Array): void {
    this.wish = points;
    if (!this.busy) this.next();
  }

  /** Comes true when every wish has been met. */
  settled(): Promise<void> {
    return this.busy ? new Promise((done) => this.waiting.push(done)) : Promise.resolve();
  }

  dispose(): void {
    this.worker.terminate();
    this.waiting.forEach((done) => done());
  }

  private next() {
    if (this.wish) {
      const points = this.wish.slice();
      this.wish = undefined;
      this.busy = true;
      this.worker.postMessage({ points, radius: this.radius }, [points.buffer]);
    } else {
      this.waiting.forEach((done) => done());
      this.waiting = [];
    }
  }
}
