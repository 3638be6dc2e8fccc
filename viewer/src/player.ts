/** Which moment of the run is shown: play, pause, step, scrub, speed, loop. Knows nothing of pictures or servers. */

export class Player {
  playing = false;
  loop = true;
  speed = 1; // run seconds per second
  private times: ArrayLike<number> = [];
  private clock = 0; // [s] of the run, while playing
  private current = 0;
  private readonly listeners: (() => void)[] = [];

  /** Called after anything a person can see has changed, until the returned function is called. */
  onChange(listener: () => void): () => void {
    this.listeners.push(listener);
    return () => this.listeners.splice(this.listeners.indexOf(listener), 1);
  }

  get frames(): number {
    return this.times.length;
  }
  get frame(): number {
    return this.current;
  }
  time(frame = this.current): number {
    return this.times[frame] ?? 0;
  }

  /** Takes the frames' times, ascending; a growing run hands over a longer list each time. */
  setTimes(times: ArrayLike<number>): void {
    this.times = times;
    this.current = Math.max(0, Math.min(this.current, times.length - 1));
    this.changed();
  }

  seek(frame: number): void {
    const last = Math.max(0, this.frames - 1);
    this.current = Math.max(0, Math.min(last, Math.round(frame)));
    this.clock = this.time();
    this.changed();
  }

  step(by: number): void {
    this.playing = false;
    this.seek(this.current + by);
  }

  /** Plays or pauses; playing from the last frame starts over. */
  toggle(): void {
    this.playing = !this.playing && this.frames > 1;
    if (this.playing && this.current === this.frames - 1) this.current = 0;
    this.clock = this.time();
    this.changed();
  }

  setSpeed(speed: number): void {
    this.speed = speed;
    this.changed();
  }

  setLoop(loop: boolean): void {
    this.loop = loop;
    this.changed();
  }

  /** Lets some real time pass, [s]. */
  advance(seconds: number): void {
    if (!this.playing || this.frames < 2) return;
    const first = this.time(0);
    const end = this.time(this.frames - 1);
    this.clock += seconds * this.speed;
    if (this.clock > end) {
      if (this.loop && end > first) {
        this.clock = first + ((this.clock - first) % (end - first));
      } else {
        this.clock = end;
        this.playing = false;
      }
    }
    const before = this.current;
    this.current = this.frameAt(this.clock);
    if (this.current !== before || !this.playing) this.changed();
  }

  /** The last frame at or before a time; the first when there is none. */
  frameAt(time: number): number {
    let lo = 0;
    let hi = this.frames - 1;
    while (lo < hi) {
      const middle = (lo + hi + 1) >> 1;
      if (this.times[middle]! <= time + 1e-12) lo = middle;
      else hi = middle - 1;
    }
    return Math.max(0, lo);
  }

  private changed() {
    for (const listener of [...this.listeners]) listener();
  }
}
