// The card with the 3D view and everything that steers it.
import type { Clock } from "./clock";
import { ColorBar, peakText, quantityNames, quantityText } from "./colorBar";
import { atNode, type Quantity } from "./coloring";
import type { Scene } from "./data";
import { element } from "./dom";
import { nearest } from "./interpolate";
import { checkbox, choice, factorSlider } from "./slider";
import { View3D, type Picked } from "./view3d";

const largestFactor = 500; // of the exaggeration

export class Player {
  readonly root = element("section", { class: "card player" });
  private play = element("button", { class: "play" });
  private slider: HTMLInputElement;
  private shown = element("output", { class: "time" });
  private bar = new ColorBar();
  private quantity: Quantity = "none";
  private perBody = false;
  private exaggeration = 1;

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
      if (view.quantities.length > 1) holder.append(this.bar.root);
      this.nameClicked(view, holder);
      return view;
    } catch (error) {
      console.warn(error);
      holder.append(element("p", { class: "hint" }, "This browser has no WebGL: the animation cannot be drawn. The plots work."));
      return null;
    }
  }

  /** A click on a body shows its name, and the values there. */
  private nameClicked(view: View3D, holder: HTMLElement): void {
    const label = element("output", { class: "picked" });
    holder.append(label);
    let picked: Picked = { body: -1, point: -1 };
    const show = () => (label.textContent = this.report.bodies[picked.body] ? this.describe(view, picked) : "");
    let pressed = [0, 0];
    view.canvas.addEventListener("pointerdown", (event) => (pressed = [event.offsetX, event.offsetY]));
    view.canvas.addEventListener("click", (event) => {
      if (Math.hypot(event.offsetX - pressed[0], event.offsetY - pressed[1]) > 4) return;
      picked = view.pick(event.offsetX, event.offsetY);
      show();
    });
    this.clock.onChange(show);
  }

  private describe(view: View3D, { body, point }: Picked): string {
    const drawn = this.report.bodies[body];
    if (drawn.pointShapes.length === 0) return drawn.name;
    let text = `${drawn.name}: deformed by up to ${(1000 * view.largestNow(body, "displacement").value).toFixed(2)} mm`;
    if (drawn.stress.length === 0) return text;
    const largest = view.largestNow(body, "stress");
    text += `, stressed by up to ${quantityText(largest.value, "stress")}${atNode(drawn, largest.point)}`;
    if (point >= 0) text += `; here ${quantityText(view.valuesNow(body, "stress")[point], "stress")}${atNode(drawn, point)}`;
    return text;
  }

  private recolor(view: View3D): void {
    view.color(this.quantity, this.perBody);
    this.showScale(view);
  }

  private showScale(view: View3D): void {
    const note = this.exaggeration > 1 ? ` (drawn ${this.exaggeration}×)` : "";
    if (this.quantity === "none") this.bar.hide();
    else if (this.perBody) this.bar.showRelative(this.quantity, note);
    else {
      const peak = view.peak(this.quantity);
      this.bar.show(this.quantity, peak.value, note, peakText(this.report.bodies, peak, this.quantity));
    }
  }

  private settings(view: View3D | null): HTMLElement {
    const row = element("div", { class: "settings" });
    // A run of milliseconds is watched slower than one of seconds.
    const slowest = Math.min(0.1, Math.max((this.clock.end - this.clock.start) / 20, 1e-4));
    row.append(factorSlider("Speed", slowest, 4, 1, (factor) => (this.clock.speed = factor)));
    if (!view) return row;
    const exaggerate = (factor: number) => {
      this.exaggeration = factor;
      view.exaggerate(factor);
      this.showScale(view);
    };
    if (view.largest > 0)
      row.append(factorSlider("Exaggerate", 1, largestFactor, view.suggested, exaggerate));
    if (view.quantities.length > 1) row.append(...this.colors(view));
    const follow = element("select", { "aria-label": "Follow" }, element("option", { value: -1 }, "nothing"));
    this.report.bodies.forEach((body, k) => follow.append(element("option", { value: k }, body.name)));
    follow.value = String(view.followed);
    follow.addEventListener("change", () => view.follow(Number(follow.value)));
    row.append(element("label", {}, element("span", {}, "Follow"), follow));
    if (this.report.bodies.some((body) => body.shapes.length > 0)) {
      row.append(checkbox("See through solids", true, (on) => view.seeThrough(on)));
    }
    const fit = element("button", { title: "Look at all bodies again" }, "Fit view");
    fit.addEventListener("click", () => view.fit());
    row.append(fit);
    return row;
  }

  private colors(view: View3D): HTMLElement[] {
    const asked = new URLSearchParams(location.hash.slice(1)).get("color") as Quantity;
    const start = view.quantities.includes(asked) ? asked : view.quantities.includes("displacement") ? "displacement" : "none";
    const options = view.quantities.map((value) => ({ value, text: quantityNames[value] }));
    const made = [
      choice("Colour", options, start, (quantity) => {
        this.quantity = quantity;
        this.recolor(view);
      }),
    ];
    if (this.report.bodies.filter((body) => body.pointShapes.length > 0).length > 1)
      made.push(
        checkbox("Scale per body", false, (on) => {
          this.perBody = on;
          this.recolor(view);
        }),
      );
    return made;
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
