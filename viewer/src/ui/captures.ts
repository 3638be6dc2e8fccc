/** What the page saves: a picture, every frame as a picture, a film. One at a time; the clock rests meanwhile. */
import type { Player } from '../player';
import { download, film, padded, pictureSequence, pngOf } from './capture';
import type { Notices } from './notices';

/** Where pictures come from. */
export interface PictureSource {
  name: () => string | undefined; // of the run
  redraw: () => void;
  showFrame: (frame: number) => Promise<void>; // and draws it
}

export class Captures {
  running = false; // frames are shown one by one for pictures
  private stop = false;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly player: Player,
    private readonly notices: Notices,
    private readonly source: PictureSource,
  ) {}

  async savePicture(): Promise<void> {
    this.source.redraw();
    download(await pngOf(this.canvas), `${this.fileName()}_${padded(this.player.frame)}.png`);
  }

  private fileName(): string {
    return (this.source.name() ?? 'run').replaceAll(/[^\w.-]+/g, '_');
  }

  /** Goes through the run for pictures or a film; escape stops. `make` gets what asks whether to go on. */
  private async run(
    what: string,
    make: (goOn: (done: number, all: number) => boolean) => Promise<void>,
  ): Promise<void> {
    if (this.running || this.player.frames === 0) return;
    this.running = true;
    this.stop = false;
    const onKey = (e: KeyboardEvent) => (this.stop ||= e.key === 'Escape');
    window.addEventListener('keydown', onKey);
    try {
      await make((done, all) => {
        this.notices.set('capture', `${what}: ${done} of ${all} (escape stops)`);
        return !this.stop;
      });
      this.notices.set('capture');
    } catch (error) {
      this.notices.set('capture', `${what} failed: ${(error as Error).message}`);
    } finally {
      window.removeEventListener('keydown', onKey);
      this.running = false;
    }
  }

  async saveSequence(): Promise<void> {
    await this.run('Saving pictures', async (goOn) => {
      const { frames } = this.player;
      const blob = await pictureSequence(
        this.canvas,
        frames,
        (f) => this.source.showFrame(f),
        (done) => goOn(done, frames),
      );
      if (blob) download(blob, `${this.fileName()}.zip`);
    });
  }

  /** Films the run once through; a film that is being made ends early, and is saved so far. */
  async toggleFilm(): Promise<void> {
    if (this.running) {
      this.stop = true;
      return;
    }
    document.body.classList.add('filming');
    await this.run('Filming', async (goOn) => {
      const blob = await film(this.canvas, this.player, (f) => this.source.showFrame(f), goOn);
      download(blob, `${this.fileName()}.webm`);
    });
    document.body.classList.remove('filming');
  }
}
