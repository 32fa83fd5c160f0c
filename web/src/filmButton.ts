// The button that makes a film of the whole animation, and stops it where it is.
import type { Clock } from "./clock";
import { element } from "./dom";
import { fileName, save } from "./download";
import { bestWay, encoded, even, filmTimes, picturesPerSecond, Recording, Stage, type Way } from "./film";
import type { View3D } from "./view3d";

const label = "Save film";

export class FilmButton {
  readonly button = element("button", { disabled: true }, label);
  /** Why there is no film; empty where there is one. */
  readonly reason = element("small", { class: "muted" });
  private stop: (() => void) | null = null; // while one is made

  constructor(
    private view: View3D,
    private clock: Clock,
  ) {
    this.button.addEventListener("click", () => (this.stop ? this.stop() : void this.make()));
    void this.offer();
  }

  private way(): Promise<Way> {
    if (!(this.clock.end > this.clock.start)) return Promise.resolve({ kind: "none", reason: "The results contain one instant only" });
    const { width, height } = this.view.canvas;
    return bestWay(even(width), even(height));
  }

  private async offer(): Promise<void> {
    const way = await this.way();
    const how = {
      pictures: `Save the whole animation at this speed as a film of ${picturesPerSecond} frames per second (WebM)`,
      recording: "Play from the start at this speed and record a film (this browser cannot encode frame by frame)",
      none: way.kind === "none" ? way.reason : "",
    };
    this.button.disabled = way.kind === "none";
    this.button.title = how[way.kind];
    this.reason.textContent = way.kind === "none" ? way.reason : "";
  }

  private async make(): Promise<void> {
    const { clock } = this;
    if (clock.playing) clock.toggle();
    let stopped = false;
    this.stop = () => (stopped = true);
    const way = await this.way(); // of the size that the picture has now
    if (way.kind === "recording") return this.record(way);
    if (way.kind === "none") return this.over();
    const stage = new Stage(this.view.canvas);
    const times = filmTimes(clock.start, clock.end, clock.speed);
    const draw = (k: number) => {
      if (stopped) return null;
      this.button.textContent = `Stop film (${Math.floor((100 * k) / times.length)} %)`;
      clock.set(times[k]);
      this.view.redraw();
      stage.draw(clock.text());
      return stage.canvas;
    };
    try {
      save(fileName("film", "webm"), await encoded(way, times.length, draw));
    } catch (error) {
      this.reason.textContent = `The film failed: ${error instanceof Error ? error.message : error}`;
    }
    this.over();
  }

  private record(way: Way & { kind: "recording" }): void {
    const { clock } = this;
    const stage = new Stage(this.view.canvas);
    const { repeats } = clock;
    clock.repeats = false; // its end is the film's
    const recording = new Recording(way, stage.canvas, (film) => {
      forget();
      if (clock.playing) clock.toggle();
      clock.repeats = repeats;
      save(fileName("film", way.type.startsWith("video/mp4") ? "mp4" : "webm"), film);
      this.over();
    });
    const forget = this.view.onDrawn(() => {
      stage.draw(clock.text());
      if (!clock.playing) setTimeout(() => recording.stop(), 100);
    });
    this.stop = () => recording.stop();
    this.button.textContent = "Stop film";
    clock.set(clock.start);
    clock.toggle();
  }

  private over(): void {
    this.stop = null;
    this.button.textContent = label;
  }
}
