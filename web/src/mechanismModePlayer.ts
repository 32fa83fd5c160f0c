// The card with the picture of a mechanism that moves in one of its modes, and everything that steers it.
import { Clock } from "./clock";
import { ColorBar, quantityNames } from "./colorBar";
import type { Quantity } from "./coloring";
import type { Scene } from "./data";
import { element, themeColor } from "./dom";
import { saveCanvas } from "./download";
import { formatNumber } from "./format";
import { dampingText, valueText } from "./mechanismModeList";
import { bendingMode, ClosedJoints, drawingFactor, fillPeriod, moveByMode, movingScene, pace, turnWhole, type MechanismModes } from "./mechanismModesData";
import { checkbox, choice, factorSlider } from "./slider";
import { View3D } from "./view3d";

const turnsPerSecond = 0.5;
const turn = 2 * Math.PI;

export class MechanismModePlayer {
  readonly root = element("section", { class: "card player" });
  private clock = new Clock(0, 1);
  private mode = 0;
  private phase = 0;
  private spin = 0; // of the whole, seen from the ground
  private fromGround = false;
  private playing = false;
  private speed = 1;
  private share = 0.1; // of the size: the largest displacement drawn
  private last = 0;
  private scene: Scene;
  private joints: ClosedJoints;
  private view: View3D | null;
  private play = element("button", { class: "play" });
  private slider = element("input", { type: "range", class: "timeline", min: 0, max: 360, step: "any", "aria-label": "Phase of the oscillation" });
  private shown = element("output", { class: "time" });
  private title = element("output", { class: "picked" });
  private numbers = element("p", { class: "note", "aria-live": "polite" });
  private bar = new ColorBar();
  private quantity: Quantity = "none";

  constructor(private report: MechanismModes) {
    this.scene = movingScene(report);
    this.joints = new ClosedJoints(report);
    const holder = element("div", { class: "view" });
    this.play.addEventListener("click", () => this.toggle());
    this.slider.addEventListener("input", () => {
      const degrees = Number(this.slider.value);
      this.pause();
      this.setPhase((degrees * Math.PI) / 180);
    });
    this.root.append(element("h2", { class: "unseen" }, "Mode shape"), holder, element("div", { class: "row transport" }, this.play, this.slider, this.shown));
    // The view looks for its bounds, and for what deforms, when it is made.
    this.mode = bendingMode(report);
    if (report.modes.length > 0) this.fill();
    this.view = this.made(holder);
    if (this.view) this.root.append(this.settings(this.view));
    this.root.append(
      this.numbers,
      element("p", { class: "hint mouse" }, "Drag to rotate, right-drag to pan, scroll to zoom"),
      element("p", { class: "hint fingers" }, "One finger scrolls the page or rotates the picture sideways; two fingers pan and zoom. After a tap on the picture one finger rotates freely until you tap outside it"),
    );
    document.addEventListener("keydown", (event) => this.key(event));
    const moving = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    const asked = new URLSearchParams(location.hash.slice(1)).get("phase");
    if (asked !== null && Number.isFinite(Number(asked))) this.setPhase((Number(asked) * Math.PI) / 180);
    else if (moving && this.view && report.modes.length > 0) this.toggle();
    this.changed();
  }

  show(mode: number): void {
    this.mode = mode;
    this.spin = 0;
    this.fill();
    const one = this.report.modes[mode];
    const what = { rigid: "rigid", real: `${formatNumber(one.value[0], 4)} 1/s`, oscillating: `${formatNumber(one.frequency, 4)} Hz, damping ratio ${dampingText(one)}` }[one.kind];
    this.title.textContent = `Mode ${mode + 1}, ${what}`;
    const still = !(one.reach > 0) && !(one.turn > 0);
    this.numbers.textContent = `λ = ${valueText(one)} 1/s. ${still ? "Nothing that is drawn moves in this mode." : one.text}`;
    this.view?.forgetPeaks();
    this.recolor();
    this.draw();
  }

  /** Few enough bodies to draw all of them twice. */
  private get few(): boolean {
    return this.report.scene.bodies.length < 200;
  }

  private get factor(): number {
    return drawingFactor(this.report.modes[this.mode], this.report.size, this.share);
  }

  private made(holder: HTMLElement): View3D | null {
    if (this.report.modes.length === 0 || this.scene.bodies.length === 0) {
      holder.append(element("p", { class: "hint" }, "There is nothing to animate."));
      return null;
    }
    try {
      const view = new View3D(this.scene, this.clock, holder, { ghosts: this.few ? [{ scene: this.report.scene, color: themeColor("muted") || "#888888" }] : [] });
      Object.assign(globalThis, { mimbreView: view }); // for the browser's console, and for tests
      view.follow(-1); // what moves is to be seen
      holder.append(this.bar.root, this.title);
      this.bar.hide();
      return view;
    } catch (error) {
      console.warn(error);
      holder.append(element("p", { class: "hint" }, "This browser has no WebGL, so the modes cannot be drawn."));
      return null;
    }
  }

  private settings(view: View3D): HTMLElement {
    const percent = (share: number) => `${Number((100 * share).toPrecision(2))} % of the size`;
    const amplitude = (share: number) => {
      this.share = share;
      this.fill();
      view.forgetPeaks();
      this.recolor();
      this.draw();
    };
    const fit = element("button", { title: "Show the whole mechanism" }, "Fit view");
    fit.addEventListener("click", () => view.fit());
    const row = element(
      "div",
      { class: "settings" },
      factorSlider("Amplitude", 0.005, 0.5, this.share, amplitude, percent),
      factorSlider("Speed", 0.1, 4, 1, (speed) => (this.speed = speed)),
      ...(this.few ? [checkbox("At rest", true, (on) => view.showGhost(0, on))] : []),
    );
    if (view.quantities.length > 1) {
      const options = view.quantities.map((value) => ({ value, text: quantityNames[value] }));
      row.append(
        choice("Colour", options, "none", (quantity: Quantity) => {
          this.quantity = quantity;
          this.recolor();
        }),
      );
    }
    if (this.report.turning > 0) {
      const seen = [
        { value: "axes", text: "axes that turn with it" },
        { value: "ground", text: "the ground" },
      ];
      row.append(
        choice("Seen from", seen, "axes", (from) => {
          this.fromGround = from === "ground";
          this.spin = 0;
          this.draw();
        }),
      );
    }
    if (this.report.scene.bodies.some((body) => body.shapes.length > 0)) row.append(checkbox("See through solids", view.hidesFlexible(), (on) => view.seeThrough(on)));
    if (this.report.scene.elements.some(({ kind }) => !["load", "drag"].includes(kind) && !kind.startsWith("tyre")))
      row.append(checkbox("Joints and springs", true, (on) => view.showElements(on)));
    const picture = element("button", { title: "Save the picture as PNG" }, "Save picture");
    picture.addEventListener("click", () => {
      view.redraw();
      saveCanvas(view.canvas, `mode-${this.mode + 1}`);
    });
    row.append(fit, picture);
    return row;
  }

  /** The period of the mode, of which the view finds the bounds and the largest deformations. */
  private fill(): void {
    fillPeriod(this.report, this.mode, this.factor, this.scene.animation);
    this.move();
  }

  /** The present instant. */
  private move(): void {
    const { animation } = this.scene;
    moveByMode(this.report, this.mode, this.factor, this.phase, animation, 0);
    this.joints.close(this.scene);
    if (this.spin !== 0) turnWhole(this.report, this.spin, animation);
  }

  private draw(): void {
    if (!this.report.modes[this.mode]) return;
    this.move();
    this.clock.set(0);
    this.changed();
  }

  private setPhase(phase: number): void {
    this.phase = phase;
    this.draw();
  }

  private recolor(): void {
    if (!this.view) return;
    this.view.color(this.quantity, true);
    if (this.quantity === "none") this.bar.hide();
    else this.bar.showRelative(this.quantity);
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
    const elapsed = (this.speed * Math.min(Math.max(now - this.last, 0), 500)) / 1000;
    this.last = now;
    const by = pace(this.report.modes[this.mode], this.fromGround ? this.report.turning : 0, turnsPerSecond);
    this.spin = this.fromGround ? (this.spin + by.spin * elapsed) % turn : 0;
    this.setPhase((this.phase + by.phase * elapsed) % turn);
    requestAnimationFrame(this.tick);
  };

  private changed(): void {
    this.play.textContent = this.playing ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", this.playing ? "Pause" : "Play");
    const degrees = (((this.phase * 180) / Math.PI) % 360 + 360) % 360;
    this.slider.value = String(degrees);
    this.shown.textContent = `${Math.round(degrees)}°`;
    this.slider.setAttribute("aria-valuetext", `${Math.round(degrees)} degrees`);
  }

  private key(event: KeyboardEvent): void {
    if (event.key !== " " || event.ctrlKey || event.metaKey || event.altKey || !(event.target instanceof Element)) return;
    // Radio buttons have no use for the space bar once one is chosen.
    if (event.target.closest("input:not([type=radio]), select, textarea, summary, pre, button")) return;
    this.toggle();
    event.preventDefault();
  }
}
