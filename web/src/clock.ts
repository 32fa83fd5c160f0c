// The animation's time, shared by the 3D view and the plots.

export class Clock {
  time: number;
  playing = false;
  speed = 1;
  private listeners: (() => void)[] = [];
  private last = 0;
  private frame = 0; // what requestAnimationFrame returned

  constructor(
    readonly start: number,
    readonly end: number,
  ) {
    this.time = start;
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  set(time: number): void {
    this.time = Math.min(Math.max(time, this.start), this.end);
    this.changed();
  }

  toggle(): void {
    if (!this.playing && this.time >= this.end) this.time = this.start;
    this.playing = !this.playing;
    this.last = performance.now();
    if (this.playing) this.frame = requestAnimationFrame(this.tick);
    else cancelAnimationFrame(this.frame);
    this.changed();
  }

  private tick = (now: number): void => {
    // A hidden tab gets no frames: do not jump when it comes back.
    const elapsed = Math.min(Math.max(now - this.last, 0), 500) / 1000;
    this.last = now;
    this.time += elapsed * this.speed;
    if (this.time >= this.end) {
      this.time = this.end;
      this.playing = false;
    } else this.frame = requestAnimationFrame(this.tick);
    this.changed();
  };

  private changed(): void {
    for (const listener of this.listeners) listener();
  }
}
