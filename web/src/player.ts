// The card with the 3D view and everything that steers it.
import { speeds, type Clock } from "./clock";
import { ColorBar, peakText, quantityNames, quantityText, viewNote } from "./colorBar";
import { atNode, has, type Quantity } from "./coloring";
import type { Element, Scene } from "./data";
import { element } from "./dom";
import { saveCanvas } from "./download";
import { FilmButton } from "./filmButton";
import { ForcePanel } from "./forcePanel";
import { formatNumber } from "./format";
import { nearest, valueAt } from "./interpolate";
import { checkbox, choice, factorSlider } from "./slider";
import { isJoint } from "./placement";
import { playFrom } from "./firstPicture";
import { quantity } from "./summaryLines";
import { isCoupling } from "./couplingView";
import { isJointLaw, jointLawText } from "./jointLawView";
import { slideOf } from "./slidingSpring";
import { isTorsional } from "./torsionView";
import { View3D, type Picked, type ViewOptions } from "./view3d";

const largestFactor = 500; // of the exaggeration

const isConstraint = (kind: string) => kind === "distance" || kind === "constant_velocity" || kind === "screw" || kind.startsWith("on_");
/** A joint's own spring or damper. */
const isOfJoint = (element: Pick<Element, "kind">) => isTorsional(element) || slideOf(element) !== null;

export class Player {
  readonly root = element("section", { class: "card player" });
  private play = element("button", { class: "play" });
  private slider: HTMLInputElement;
  private shown = element("output", { class: "time" });
  private bar = new ColorBar();
  private quantity: Quantity = "none";
  private perBody = false;
  private exaggeration = 1;
  private note = element("small", { class: "cell" });
  /** For screen readers: the time at which the animation rests. */
  private spoken = element("p", { class: "unseen", "aria-live": "polite" });
  private speaking = 0;
  private forces?: ForcePanel;
  /** Describes again what was clicked. */
  private pickedChanged = (): void => {};
  view: View3D | null = null;

  constructor(
    private report: Scene,
    private clock: Clock,
    private options: ViewOptions = {},
  ) {
    const holder = element("div", { class: "view" });
    const { time } = report.animation;
    this.slider = element("input", { type: "range", class: "timeline", min: clock.start, max: clock.end, step: "any", "aria-label": "Time" });
    this.slider.addEventListener("input", () => clock.stopAt(Number(this.slider.value)));
    this.play.addEventListener("click", () => clock.toggle());
    this.root.append(element("h2", { class: "unseen" }, "Animation"), holder, element("div", { class: "row transport" }, this.play, this.slider, this.shown));
    this.view = this.made(holder);
    if (this.view) this.start(this.view);
    this.root.append(this.spoken, this.settings(this.view));
    if (this.view) this.root.append(this.exports(this.view));
    const key = (name: string) => element("kbd", {}, name);
    this.root.append(
      element("p", { class: "hint mouse" }, "Drag to rotate, right-drag to pan, scroll to zoom · ", key("Space"), " play · ", key("←"), " ", key("→"), " step. With the picture focused, the arrow keys rotate it"),
      element("p", { class: "hint fingers" }, "One finger scrolls the page or rotates the picture sideways; two fingers pan and zoom. Tap a part to read its values; one finger then rotates freely until you tap outside the picture"),
    );
    clock.onChange(() => this.changed());
    this.changed();
    this.play.disabled = time.length < 2;
    if (time.length > 0) document.addEventListener("keydown", (event) => this.key(event));
  }

  /** Plays from a moment before the instant at which most happens; with reduced motion, rests at it. */
  private start(view: View3D): void {
    const { clock } = this;
    const instant = view.tellingInstant();
    const resting = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const from = resting ? instant : playFrom(instant, clock.start, speeds(clock.end - clock.start)[2]);
    clock.set(from);
    view.fit();
    if (resting) return;
    const forget = view.onDrawn(() => {
      forget();
      // Unless another time was asked for before the first picture.
      if (!clock.playing && clock.time === from) clock.toggle();
    });
  }

  private made(holder: HTMLElement): View3D | null {
    if (this.report.bodies.length === 0 || this.report.animation.time.length === 0) {
      holder.append(element("p", { class: "hint" }, "The results contain nothing to animate."));
      return null;
    }
    try {
      const view = new View3D(this.report, this.clock, holder, this.options);
      Object.assign(globalThis, { mimbreView: view }); // for the browser's console, and for tests
      if (view.quantities.length > 1) holder.append(this.bar.root);
      const forget = view.onDrawn(() => {
        forget();
        this.bar.root.classList.toggle("left", view.emptierLeft());
      });
      holder.append(this.note);
      this.nameClicked(view, holder);
      return view;
    } catch (error) {
      console.warn(error);
      holder.append(element("p", { class: "hint" }, "This browser has no WebGL, so the animation cannot be drawn. The plots work."));
      return null;
    }
  }

  /** A click on a body shows its name, and the values there. */
  private nameClicked(view: View3D, holder: HTMLElement): void {
    const label = element("output");
    const box = element("input", { type: "checkbox" });
    const arrow = element("label", {}, box, element("span", {}, "arrow"));
    const card = element("div", { class: "picked", hidden: true }, label, arrow);
    holder.append(card);
    let picked: Picked = { body: -1, point: -1, element: -1 };
    const show = () => {
      const something = picked.element >= 0 || this.report.bodies[picked.body];
      label.textContent = something ? this.describe(view, picked) : "";
      card.hidden = !something;
      const joint = this.reacting(picked.element);
      arrow.hidden = !joint || !this.forces?.offers(joint);
      box.checked = !arrow.hidden && this.forces!.ticked(joint!);
    };
    box.addEventListener("change", () => this.forces?.tick(this.reacting(picked.element)!, box.checked));
    this.pickedChanged = show;
    let pressed = [0, 0];
    view.canvas.addEventListener("pointerdown", (event) => (pressed = [event.offsetX, event.offsetY]));
    view.canvas.addEventListener("click", (event) => {
      if (Math.hypot(event.offsetX - pressed[0], event.offsetY - pressed[1]) > 4) return;
      picked = view.pick(event.offsetX, event.offsetY);
      show();
    });
    this.clock.onChange(show);
  }

  /** What is picked, or of a joint's own spring the joint. */
  private reacting(index: number): Element | undefined {
    const { elements } = this.report;
    const one = elements[index];
    return one && isOfJoint(one) ? elements.find((joint) => isJoint(joint) && joint.name === one.name) : one;
  }

  /** A joint, spring or load: what it is, and its force now. */
  private describeElement(index: number): string {
    const { name, kind } = this.report.elements[index];
    const now = (channel: string) => {
      const signal = this.report.signals?.(channel);
      return signal ? valueAt(signal.time, signal.values, this.clock.time) : null;
    };
    if (isJointLaw(kind)) return `${name}, ${jointLawText(kind)}`;
    if (isCoupling(kind) || kind === "bushing") return `${name}, ${kind}`;
    if (isOfJoint({ kind })) return `${name}: ${kind.replace(/ (about|along) .*/, "")} of the joint`;
    if (kind.includes("spring") || kind.includes("damper") || kind === "actuator") {
      const [force, length] = [now(`spring.${name}.force`), now(`spring.${name}.length`)];
      const tension = force === null ? "" : `: ${force < 0 ? "compression" : "tension"} ${quantity(Math.abs(force), "N")}`;
      return `${name}, ${kind}${tension}${length === null ? "" : `, length ${quantity(length, "m", 4)}`}`;
    }
    const sizes = (of: string, what: string) => Math.hypot(...["x", "y", "z"].map((axis) => now(`${of}.${name}.${what}.${axis}`) ?? NaN));
    if (isConstraint(kind)) {
      const [force, moment] = [sizes("constraint", "force"), sizes("constraint", "moment")];
      const carried = [Number.isFinite(force) ? quantity(force, "N") : "", Number.isFinite(moment) ? quantity(moment, "N m") : ""].filter((text) => text);
      return `${name}, ${kind.replace(/_/g, " ")}${carried.length > 0 ? `: ${carried.join(", ")}` : ""}`;
    }
    const [force, moment] = [sizes("joint", "force"), sizes("joint", "moment")];
    const note = kind === "bracket" ? " (fixed, with static modes of its flexible bodies)" : "";
    return `${name}, ${kind} joint${note}${Number.isFinite(force) ? `: ${quantity(force, "N")}, ${quantity(moment, "N m")}` : ""}`;
  }

  private describe(view: View3D, { body, point, element }: Picked): string {
    if (element >= 0) return this.describeElement(element);
    const drawn = this.report.bodies[body];
    if (drawn.pointShapes.length === 0) return drawn.name;
    let text = `${drawn.name}: deformation up to ${quantityText(view.largestNow(body, "displacement").value, "displacement")}`;
    if (!has(drawn, "stress")) return text;
    const largest = view.largestNow(body, "stress");
    text += `, von Mises stress up to ${quantityText(largest.value, "stress")}${atNode(drawn, largest.point)}`;
    if (point >= 0) text += `; here ${quantityText(view.valuesNow(body, "stress")[point], "stress")}${atNode(drawn, point)}`;
    return text;
  }

  private recolor(view: View3D): void {
    view.color(this.quantity, this.perBody);
    this.showScale(view);
  }

  private showScale(view: View3D): void {
    this.note.textContent = viewNote(view.cell, this.exaggeration);
    if (this.quantity === "none") this.bar.hide();
    else if (this.perBody) this.bar.showRelative(this.quantity);
    else {
      const peak = view.peak(this.quantity);
      this.bar.show(this.quantity, peak.value, peakText(this.report.bodies, peak, this.quantity));
    }
  }

  private settings(view: View3D | null): HTMLElement {
    const row = element("div", { class: "settings" });
    const [slowest, fastest, start] = speeds(this.clock.end - this.clock.start);
    row.append(factorSlider("Speed", slowest, fastest, start, (factor) => (this.clock.speed = factor), (factor) => `${formatNumber(factor)}×`));
    row.append(checkbox("Repeat", true, (on) => (this.clock.repeats = on)));
    if (!view) return row;
    const exaggerate = (factor: number) => {
      this.exaggeration = factor;
      view.exaggerate(factor);
      this.showScale(view);
    };
    if (view.largest > 0)
      row.append(factorSlider("Exaggeration", 1, largestFactor, view.firstExaggeration(largestFactor), exaggerate));
    else this.showScale(view);
    if (view.quantities.length > 1) row.append(...this.colors(view));
    const follow = element("select", { "aria-label": "Follow" }, element("option", { value: -1 }, "nothing"));
    this.report.bodies.forEach((body, k) => follow.append(element("option", { value: k }, body.name)));
    follow.value = String(view.followed);
    follow.addEventListener("change", () => view.follow(Number(follow.value)));
    row.append(element("label", {}, element("span", {}, "Follow"), follow));
    if (this.report.bodies.some((body) => body.shapes.length > 0)) {
      row.append(checkbox("See through solids", view.hidesFlexible(), (on) => view.seeThrough(on)));
    }
    if (this.report.elements.some(({ kind }) => !["load", "drag"].includes(kind) && !kind.startsWith("tyre")))
      row.append(checkbox("Joints and springs", true, (on) => view.showElements(on)));
    this.forces = new ForcePanel(view, () => this.pickedChanged());
    row.append(...this.forces.parts);
    return row;
  }

  /** The picture and the film as files, and the view as it was. */
  private exports(view: View3D): HTMLElement {
    const fit = element("button", { title: "Show all bodies" }, "Fit view");
    fit.addEventListener("click", () => view.fit());
    const picture = element("button", { title: "Save the picture as PNG" }, "Save picture");
    picture.addEventListener("click", () => {
      view.redraw();
      saveCanvas(view.canvas, `t${this.clock.text().replace(" ", "")}`);
    });
    const film = new FilmButton(view, this.clock);
    return element("div", { class: "row exports" }, fit, picture, film.button, film.reason);
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
    this.shown.textContent = this.clock.text();
    this.slider.setAttribute("aria-valuetext", this.shown.textContent);
    clearTimeout(this.speaking);
    if (!playing) this.speaking = window.setTimeout(() => (this.spoken.textContent = `Time ${this.shown.textContent}`), 400);
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
    this.clock.stopAt(time[index]);
  }
}
