// The animation's time, shared by the 3D view and the plots.
import { timeText } from "./engineering";
import { niceLength } from "./surroundings";

/** Slowest, fastest and first speed at which a run so long is watched: one of milliseconds slowly, one of hours fast. */
export function speeds(duration: number): [number, number, number] {
  if (!(duration > 0)) return [0.1, 4, 1];
  const slowest = Math.min(0.1, duration / 20);
  const fastest = Math.max(4, duration / 10);
  const start = duration < 0.3 ? niceLength(duration / 4) : duration > 300 ? niceLength(duration / 60) : 1;
  return [slowest, fastest, start];
}

export class Clock {
  time: number;
  playing = false;
  speed = 1;
  /** At the end it begins again. */
  repeats = false;
  private listeners: (() => void)[] = [];
  private last = 0;
  private frame = 0; // what requestAnimationFrame returned

  private words: (time: number) => string;

  /** `instants`: number of instants of the animation, which the text of the time distinguishes. */
  constructor(
    readonly start: number,
    readonly end: number,
    instants = 0,
  ) {
    this.time = start;
    this.words = timeText(start, end, instants);
  }

  /** The time with its unit. */
  text(): string {
    return this.words(this.time);
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  set(time: number): void {
    this.time = Math.min(Math.max(time, this.start), this.end);
    this.changed();
  }

  /** Stops at a time. */
  stopAt(time: number): void {
    if (this.playing) this.toggle();
    this.set(time);
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
      this.time = this.repeats ? this.start : this.end;
      this.playing = this.repeats;
    }
    if (this.playing) this.frame = requestAnimationFrame(this.tick);
    this.changed();
  };

  private changed(): void {
    for (const listener of this.listeners) listener();
  }
}
