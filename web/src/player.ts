// The card with the 3D view and everything that steers it.
import type { Clock } from "./clock";
import { turboGradient } from "./color";
import type { Scene } from "./data";
import { element } from "./dom";
import { formatNumber } from "./format";
import { nearest } from "./interpolate";
import { View3D } from "./view3d";

const largestFactor = 500; // of the exaggeration

/** A labelled slider over a factor from `low` to `high`, logarithmic. */
function factorSlider(label: string, low: number, high: number, start: number, changed: (factor: number) => void): HTMLElement {
  const ratio = high / low;
  const shown = element("output");
  const slider = element("input", { type: "range", min: 0, max: 1, step: 0.001, "aria-label": label });
  const update = () => {
    const factor = low * ratio ** Number(slider.value);
    const rounded = Number(factor.toPrecision(2));
    shown.textContent = `${rounded}×`;
    slider.setAttribute("aria-valuetext", shown.textContent);
    changed(rounded);
  };
  slider.value = String(Math.log(start / low) / Math.log(ratio));
  slider.addEventListener("input", update);
  update();
  return element("label", { class: "factor" }, element("span", {}, label), slider, shown);
}

function colorBar(largest: number, caption: HTMLElement): HTMLElement {
  const bar = element("div", { class: "bar" });
  bar.style.background = turboGradient("to right");
  const millimetres = (value: number) => formatNumber(1000 * value, 3);
  return element(
    "div",
    { class: "colorbar", title: "Displacement of the flexible bodies' points against their undeformed shape (not exaggerated)" },
    caption,
    bar,
    element("div", { class: "ends" }, element("span", {}, "0"), element("span", {}, millimetres(largest / 2)), element("span", {}, millimetres(largest))),
  );
}

export class Player {
  readonly root = element("section", { class: "card player" });
  private play = element("button", { class: "play" });
  private slider: HTMLInputElement;
  private shown = element("output", { class: "time" });
  private caption = element("span"); // of the colour bar

  constructor(
    private report: Scene,
    private clock: Clock,
  ) {
    const holder = element("div", { class: "view" });
    const { time } = report.animation;
    this.slider = element("input", { type: "range", class: "timeline", min: clock.start, max: clock.end, step: "any", "aria-label": "Time" });
    this.slider.addEventListener("input", () => clock.set(Number(this.slider.value)));
    this.play.addEventListener("click", () => clock.toggle());
    this.root.append(element("h2", { class: "unseen" }, "Animation"), holder, element("div", { class: "row transport" }, this.play, this.slider, this.shown));
    const view = this.view(holder);
    this.root.append(this.settings(view));
    this.root.append(
      element("p", { class: "hint keys" }, "Drag to turn, right-drag to move, scroll to zoom · ", element("kbd", {}, "Space"), " play · ", element("kbd", {}, "←"), " ", element("kbd", {}, "→"), " step"),
    );
    clock.onChange(() => this.changed());
    this.changed();
    this.play.disabled = time.length < 2;
    if (time.length > 0) document.addEventListener("keydown", (event) => this.key(event));
  }

  private view(holder: HTMLElement): View3D | null {
    if (this.report.bodies.length === 0 || this.report.animation.time.length === 0) {
      holder.append(element("p", { class: "hint" }, "The results hold nothing to animate."));
      return null;
    }
    try {
      const view = new View3D(this.report, this.clock, holder);
      if (view.largest > 0) holder.append(colorBar(view.largest, this.caption));
      this.nameClicked(view, holder);
      return view;
    } catch (error) {
      console.warn(error);
      holder.append(element("p", { class: "hint" }, "This browser has no WebGL: the animation cannot be drawn. The plots work."));
      return null;
    }
  }

  /** A click on a body shows its name. */
  private nameClicked(view: View3D, holder: HTMLElement): void {
    const label = element("output", { class: "picked" });
    holder.append(label);
    let picked = -1;
    const show = () => {
      const body = this.report.bodies[picked];
      if (!body) label.textContent = "";
      else if (body.pointShapes.length === 0) label.textContent = body.name;
      else label.textContent = `${body.name}: deformed by up to ${(1000 * view.displacement(picked)).toFixed(2)} mm`;
    };
    let pressed = [0, 0];
    view.canvas.addEventListener("pointerdown", (event) => (pressed = [event.offsetX, event.offsetY]));
    view.canvas.addEventListener("click", (event) => {
      if (Math.hypot(event.offsetX - pressed[0], event.offsetY - pressed[1]) > 4) return;
      picked = view.pick(event.offsetX, event.offsetY);
      show();
    });
    this.clock.onChange(show);
  }

  private settings(view: View3D | null): HTMLElement {
    const row = element("div", { class: "settings" });
    // A run of milliseconds is watched slower than one of seconds.
    const slowest = Math.min(0.1, Math.max((this.clock.end - this.clock.start) / 20, 1e-4));
    row.append(factorSlider("Speed", slowest, 4, 1, (factor) => (this.clock.speed = factor)));
    if (!view) return row;
    const exaggerate = (factor: number) => {
      view.exaggerate(factor);
      this.caption.textContent = factor > 1 ? `Deformation, mm (drawn ${factor}×)` : "Deformation, mm";
    };
    if (view.largest > 0)
      row.append(factorSlider("Exaggerate", 1, largestFactor, view.suggested, exaggerate));
    const follow = element("select", { "aria-label": "Follow" }, element("option", { value: -1 }, "nothing"));
    this.report.bodies.forEach((body, k) => follow.append(element("option", { value: k }, body.name)));
    follow.value = String(view.followed);
    follow.addEventListener("change", () => view.follow(Number(follow.value)));
    row.append(element("label", {}, element("span", {}, "Follow"), follow));
    if (this.report.bodies.some((body) => body.shapes.length > 0)) {
      const box = element("input", { type: "checkbox" });
      box.checked = true;
      view.seeThrough(true);
      box.addEventListener("change", () => view.seeThrough(box.checked));
      row.append(element("label", {}, box, element("span", {}, "See through solids")));
    }
    const fit = element("button", { title: "Look at all bodies again" }, "Fit view");
    fit.addEventListener("click", () => view.fit());
    row.append(fit);
    return row;
  }

  private changed(): void {
    const { time, playing } = this.clock;
    this.play.textContent = playing ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", playing ? "Pause" : "Play");
    this.slider.value = String(time);
    this.shown.textContent = `${time.toFixed(3)} s`;
    this.slider.setAttribute("aria-valuetext", this.shown.textContent);
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || !(event.target instanceof Element)) return;
    // Where a key already means something (typing, a slider, a button), it keeps its meaning.
    if (event.target.closest("input, select, textarea, summary, pre")) return;
    if (event.key === " " && !event.target.closest("button")) this.clock.toggle();
    else if (event.key === "ArrowLeft") this.step(event.shiftKey ? -10 : -1);
    else if (event.key === "ArrowRight") this.step(event.shiftKey ? 10 : 1);
    else return;
    event.preventDefault();
  }

  private step(count: number): void {
    const { time } = this.report.animation;
    const index = Math.min(Math.max(nearest(time, this.clock.time) + count, 0), time.length - 1);
    this.clock.set(time[index]);
  }
}
