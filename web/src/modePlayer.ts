// The card with the picture of a mode, swinging, and everything that steers it.
import { Clock } from "./clock";
import { ColorBar, quantityNames, quantityText } from "./colorBar";
import { atNode, type Quantity } from "./coloring";
import { element } from "./dom";
import { formatNumber } from "./format";
import { FrameView } from "./frameView";
import { amplitudesOf, swing, swingScene, type ModesReport } from "./modesData";
import { checkbox, choice, factorSlider } from "./slider";
import { View3D } from "./view3d";

const swingsPerSecond = 0.5;

/** The diagonal of the box around the points. */
function sizeOf(points: ArrayLike<number>): number {
  let square = 0;
  for (let axis = 0; axis < 3; ++axis) {
    let low = Infinity;
    let high = -Infinity;
    for (let k = axis; k < points.length; k += 3) {
      low = Math.min(low, points[k]);
      high = Math.max(high, points[k]);
    }
    if (high > low) square += (high - low) ** 2;
  }
  return Math.sqrt(square);
}

export class ModePlayer {
  readonly root = element("section", { class: "card player" });
  /** From −1 to 1, the extremes of the swing. */
  readonly clock = new Clock(-1, 1);
  private playing = false;
  private phase = Math.PI / 2;
  private speed = 1;
  private last = 0;
  private play = element("button", { class: "play" });
  private slider = element("input", { type: "range", class: "timeline", min: -1, max: 1, step: "any", "aria-label": "Phase of the oscillation" });
  private bar = new ColorBar();
  private title = element("output", { class: "picked" });
  private numbers = element("p", { class: "note", "aria-live": "polite" });
  private view: View3D | null;
  private triads: FrameView[] = [];
  private scene;
  private size: number;
  private share = 0.1; // of the size: the largest displacement drawn
  private quantity: Quantity = "displacement";

  constructor(private report: ModesReport) {
    this.scene = swingScene(report.body, new Float32Array(report.body.modes));
    this.size = sizeOf(report.body.points) || 1;
    const holder = element("div", { class: "view" });
    this.play.addEventListener("click", () => this.toggle());
    this.slider.addEventListener("input", () => {
      this.phase = Math.asin(Math.min(Math.max(Number(this.slider.value), -1), 1));
      this.pause();
      this.clock.set(Math.sin(this.phase));
    });
    this.root.append(element("h2", { class: "unseen" }, "Mode shape"), holder, element("div", { class: "row transport" }, this.play, this.slider));
    this.view = this.makeView(holder);
    if (this.view) this.root.append(this.settings(this.view));
    this.root.append(this.numbers, element("p", { class: "hint mouse" }, "Drag to rotate, right-drag to pan, scroll to zoom"), element("p", { class: "hint fingers" }, "One finger scrolls the page or rotates the picture sideways; two fingers pan and zoom. After a tap on the picture one finger rotates freely until you tap outside it"));
    this.clock.onChange(() => this.changed());
    document.addEventListener("keydown", (event) => this.key(event));
    this.clock.set(1);
    const moving = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (moving && this.view && !location.hash.includes("t=")) this.toggle();
  }

  show(family: number, mode: number): void {
    const { name, frequency } = this.report.families[family].modes[mode];
    this.scene.animation.modes.set(swing(amplitudesOf(this.report, family, mode)));
    this.title.textContent = frequency === null ? name : `${name}, ${formatNumber(frequency)} Hz`;
    if (!this.view) return;
    this.view.forgetPeaks();
    this.scaleUp();
    this.recolor();
    this.numbers.textContent = this.extremes();
  }

  private makeView(holder: HTMLElement): View3D | null {
    const { body, frames } = this.report;
    if (body.lines.length === 0 && body.triangles.length === 0) {
      holder.append(element("p", { class: "hint" }, "The body's file contains nothing to draw."));
      return null;
    }
    try {
      const view = new View3D(this.scene, this.clock, holder, { steadyColors: true, grid: false });
      Object.assign(globalThis, { mimbreView: view }); // for the browser's console, and for tests
      holder.append(this.bar.root, this.title);
      const triads = frames.map((frame) => new FrameView(frame, 0.09 * this.size));
      triads.forEach((triad) => view.attach(0, triad.group, (amplitudes, exaggeration) => triad.update(amplitudes, exaggeration)));
      this.triads = triads;
      return view;
    } catch (error) {
      console.warn(error);
      holder.append(element("p", { class: "hint" }, "This browser has no WebGL, so the modes cannot be drawn."));
      return null;
    }
  }

  private settings(view: View3D): HTMLElement {
    const quantities = (["displacement", "stress", "none"] as const).filter((quantity) => quantity !== "stress" || this.report.body.stress.length > 0);
    const asked = new URLSearchParams(location.hash.slice(1)).get("color") as Quantity;
    const start = quantities.includes(asked as (typeof quantities)[number]) ? asked : "displacement";
    const percent = (share: number) => `${Number((100 * share).toPrecision(2))} % of the size`;
    const amplitude = (share: number) => {
      this.share = share;
      this.scaleUp();
    };
    const fit = element("button", { title: "Show the whole body" }, "Fit view");
    fit.addEventListener("click", () => view.fit());
    const row = element(
      "div",
      { class: "settings" },
      factorSlider("Amplitude", 0.005, 0.5, this.share, amplitude, percent),
      factorSlider("Speed", 0.1, 4, 1, (speed) => (this.speed = speed)),
      choice(
        "Colour",
        quantities.map((value) => ({ value, text: quantityNames[value] })),
        start,
        (quantity: Quantity) => {
          this.quantity = quantity;
          this.recolor();
        },
      ),
      checkbox("Undeformed", this.report.body.triangles.length > 0 || this.report.body.lines.length < 400, (on) => view.showUndeformed(on)),
    );
    if (this.triads.length > 0)
      row.append(
        checkbox("Interfaces", true, (on) => {
          for (const triad of this.triads) triad.group.visible = on;
          this.clock.set(this.clock.time);
        }),
      );
    row.append(fit);
    return row;
  }

  /** The factor that draws the largest displacement as large as it is wanted. */
  private scaleUp(): void {
    const largest = this.view?.peak("displacement").value ?? 0;
    this.view?.exaggerate(largest > 0 ? (this.share * this.size) / largest : 1);
  }

  private recolor(): void {
    if (!this.view) return;
    const { value } = this.view.peak(this.quantity);
    this.view.color(this.quantity);
    if (this.quantity === "none" || value === 0) this.bar.hide();
    else this.bar.show(this.quantity, value, "", " at amplitude 1");
  }

  /** The largest values of the mode, and their ratio. */
  private extremes(): string {
    const { body } = this.report;
    const moved = this.view!.peak("displacement");
    let text = `At amplitude 1: deformation up to ${quantityText(moved.value, "displacement", 4)}${atNode(body, moved.point)}`;
    if (body.stress.length === 0) return `${text}.`;
    const stressed = this.view!.peak("stress");
    text += `, von Mises stress up to ${quantityText(stressed.value, "stress", 4)}${atNode(body, stressed.point)}`;
    if (moved.value > 0) text += `: ${quantityText(stressed.value / moved.value / 1000, "stress", 4)} per mm of deformation`;
    return `${text}.`;
  }

  private toggle(): void {
    if (this.playing) return this.pause();
    this.playing = true;
    this.last = performance.now();
    requestAnimationFrame(this.tick);
    this.changed();
  }

  private pause(): void {
    this.playing = false;
    this.changed();
  }

  private tick = (now: number): void => {
    if (!this.playing) return;
    // A hidden tab gets no frames: do not jump when it comes back.
    const elapsed = Math.min(Math.max(now - this.last, 0), 500) / 1000;
    this.last = now;
    this.phase += 2 * Math.PI * swingsPerSecond * this.speed * elapsed;
    this.clock.set(Math.sin(this.phase));
    requestAnimationFrame(this.tick);
  };

  private changed(): void {
    this.play.textContent = this.playing ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", this.playing ? "Pause" : "Play");
    this.slider.value = String(this.clock.time);
    this.slider.setAttribute("aria-valuetext", `${Math.round(100 * this.clock.time)} % of the amplitude`);
  }

  private key(event: KeyboardEvent): void {
    if (event.key !== " " || event.ctrlKey || event.metaKey || event.altKey || !(event.target instanceof Element)) return;
    // Radio buttons have no use for the space bar once one is chosen.
    if (event.target.closest("input:not([type=radio]), select, textarea, summary, pre, button")) return;
    this.toggle();
    event.preventDefault();
  }
}
