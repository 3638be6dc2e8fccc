/** Brings the frame at which the player stands into the picture, and fetches ahead while it plays. */
import type { FrameCache } from './frame_cache';
import type { Player } from './player';
import type { Frame } from './run';
import type { Notices } from './ui/notices';

export class FrameFollower {
  private requested: number | undefined; // frame on its way to the picture
  private failed = -1; // frame the server could not give

  constructor(
    private readonly player: Player,
    private readonly cache: FrameCache,
    private readonly notices: Notices,
    private readonly picture: { shown: () => number | undefined; display: (frame: Frame) => void },
  ) {}

  /** A frame that could not be had may be there now. */
  tryAgain(): void {
    this.failed = -1;
  }

  /** Brings the player's frame into the picture, at once if it is here, else when it comes. */
  follow() {
    const { player, cache, notices } = this;
    const wanted = player.frame;
    if (player.frames === 0 || this.requested !== undefined) return;
    if (this.picture.shown() !== wanted && this.failed !== wanted) {
      const here = cache.peek(wanted);
      if (here) this.picture.display(here);
      else {
        this.requested = wanted;
        cache
          .get(wanted)
          .then((frame) => {
            this.failed = -1;
            notices.set('frame');
            this.picture.display(frame);
          })
          .catch((error: unknown) => {
            this.failed = wanted;
            if (!notices.has('lost'))
              notices.set('frame', `Frame ${wanted + 1} cannot be shown: ${(error as Error).message}`);
          })
          .finally(() => (this.requested = undefined));
      }
    }
    if (player.playing) {
      const stride = Math.max(1, Math.round(player.speed));
      const ahead = Array.from({ length: 8 }, (_, i) => (wanted + (i + 1) * stride) % player.frames);
      cache.prefetch(ahead);
    }
  }
}
