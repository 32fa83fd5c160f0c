// The card with the 3D view of what happens now.
import * as THREE from "three";
import { Clock } from "./clock";
import { ColorBar, quantityNames, viewNote } from "./colorBar";
import { has, type Quantity } from "./coloring";
import type { Scene, Signals } from "./data";
import { element } from "./dom";
import { saveCanvas } from "./download";
import { ForcePanel } from "./forcePanel";
import { niceAbove } from "./arrows";
import { fill, liveAnimation, type Between } from "./livePictures";
import type { LiveScene, Picture } from "./liveProtocol";
import { checkbox, choice, factorSlider } from "./slider";
import { View3D } from "./view3d";

const largestFactor = 500; // of the deformation scale
const lag = 0.35; // s, of the chasing eye
const [slow, patience] = [0.07, 3]; // s between pictures that are too far apart, s that it is looked at
const scaleEvery = 0.2; // s, in which the colours' scale is looked after

/** The first body that moves freely against the ground, else the one whose drawing is the largest; −1: none. */
export function leadingBody({ bodies, frames, elements }: Scene): number {
  const free = elements.find(({ kind, a, b }) => kind === "floating" && (frames[a]?.body ?? -1) < 0 && (frames[b]?.body ?? -1) >= 0);
  if (free) return frames[free.b].body;
  const size = (body: Scene["bodies"][number]) => {
    const box = new THREE.Box3();
    for (let k = 0; k < body.points.length; k += 3) box.expandByPoint(new THREE.Vector3(body.points[k], body.points[k + 1], body.points[k + 2]));
    for (const { size, position } of body.shapes) box.union(new THREE.Box3().setFromCenterAndSize(new THREE.Vector3(...(position as [number, number, number])), new THREE.Vector3().setScalar(Math.max(...size))));
    return box.isEmpty() ? 0 : box.getSize(new THREE.Vector3()).length();
  };
  const sizes = bodies.map(size);
  return sizes.length > 0 ? sizes.indexOf(Math.max(...sizes)) : -1;
}

/** Of a body's x axis about z, from a quaternion w x y z. */
export function heading(w: number, x: number, y: number, z: number): number {
  return Math.atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z));
}

/** The shorter way from one angle to another. */
export function turnBetween(from: number, to: number): number {
  const turn = (to - from) % (2 * Math.PI);
  return turn > Math.PI ? turn - 2 * Math.PI : turn < -Math.PI ? turn + 2 * Math.PI : turn;
}

type Camera = "still" | "follow" | "chase";

export class LiveView {
  readonly root = element("section", { class: "card player" });
  readonly holder = element("div", { class: "view" });
  readonly view: View3D | null;
  private clock: Clock;
  private scene: Scene;
  private values = new Map<string, { time: Float64Array; values: (number | null)[] }>();
  private bar = new ColorBar();
  private quantity: Quantity = "none";
  private exaggeration = 1;
  private note = element("small", { class: "cell" });
  private ends: number[]; // the largest of each body so far
  private looked = 0; // when the ends were last looked after, s of this machine
  private forces?: ForcePanel;
  private camera: Camera = "follow";
  private leader: number;
  private seen = NaN; // heading that the chasing eye has
  private shown = 0; // when the last picture was, s of this machine
  private watched = { since: 0, drawn: 0 }; // pictures since a time of this machine
  private fine: HTMLInputElement | null = null;

  constructor(
    private live: LiveScene,
    /** Other channels are needed for the arrows. */
    private needed: () => void,
  ) {
    const { scene } = live;
    const animation = liveAnimation(scene.animation);
    this.scene = { ...scene, animation, signals: this.signals() };
    this.clock = new Clock(animation.time[0], Infinity);
    this.ends = scene.bodies.map(() => 0);
    this.leader = leadingBody(scene);
    this.root.append(element("h2", { class: "unseen" }, "Picture"), this.holder);
    this.view = this.made();
    if (this.view) this.root.append(this.settings(this.view));
  }

  /** Channels that the arrows need now. */
  get channels(): string[] {
    const plates = this.scene.elements.filter(({ kind }) => kind === "tyre on rig").map(({ name }) => `tyre.${name}.road`);
    return [...plates, ...(this.view?.arrows.channels ?? [])].filter((name) => this.values.has(name));
  }

  /** `value`: of a channel in a picture, where it has it. */
  show(between: Between, value: (name: string, picture: Picture) => number | null, now: number): void {
    const { view } = this;
    const still = between.time === this.clock.time;
    // A paused simulation is drawn only now and then: that does not measure the speed of drawing.
    if (still) this.watched = { since: now, drawn: 0 };
    if (!view || (still && now - this.looked < scaleEvery)) return;
    fill(this.scene.animation, between);
    for (const name of this.channels) {
      const { time, values } = this.values.get(name)!;
      time.set(this.scene.animation.time);
      values[0] = value(name, between.earlier);
      values[1] = value(name, between.later);
    }
    if (this.camera === "chase") this.chase(view, between, now);
    this.shown = now;
    this.saveWork(now);
    this.clock.set(between.time);
    view.flush(); // waiting for the next picture of the screen would leave out every other
    if (now - this.looked < scaleEvery) return;
    this.looked = now;
    this.rescale(view);
    this.forces?.refreshScale();
  }

  private signals(): Signals {
    const names = new Set(this.live.channels.map(({ name }) => name));
    return (name) => {
      if (!names.has(name)) return null;
      let known = this.values.get(name);
      if (!known) this.values.set(name, (known = { time: new Float64Array(2), values: [null, null] }));
      return known;
    };
  }

  private made(): View3D | null {
    if (this.scene.bodies.length === 0) {
      this.holder.append(element("p", { class: "hint" }, "The model contains no bodies to draw."));
      return null;
    }
    try {
      const view = new View3D(this.scene, this.clock, this.holder, { live: true, from: () => this.behind() });
      view.canvas.setAttribute("aria-label", "The mechanism as it moves now; arrow keys rotate the view, + and − zoom");
      Object.assign(globalThis, { mimbreView: view }); // for the browser's console, and for tests
      if (view.quantities.length > 1) this.holder.append(this.bar.root);
      this.holder.append(this.note);
      return view;
    } catch (error) {
      console.warn(error);
      this.holder.append(element("p", { class: "hint" }, "This browser has no WebGL, so the mechanism cannot be drawn. The charts and controls work."));
      return null;
    }
  }

  private settings(view: View3D): HTMLElement {
    const row = element("div", { class: "settings" });
    const cameras: { value: Camera; text: string }[] = [
      { value: "chase", text: "chases" },
      { value: "follow", text: "follows" },
      { value: "still", text: "fixed" },
    ];
    const floats = this.scene.elements.some(({ kind }) => kind === "floating");
    row.append(choice("Camera", cameras, !floats ? "still" : matchMedia("(prefers-reduced-motion: reduce)").matches ? "follow" : "chase", (camera) => this.look(view, camera)));
    const follow = element("select", { "aria-label": "Followed body" });
    this.scene.bodies.forEach((body, k) => follow.append(element("option", { value: k }, body.name)));
    follow.value = String(this.leader);
    follow.addEventListener("change", () => {
      this.leader = Number(follow.value);
      this.look(view, this.camera);
    });
    row.append(element("label", {}, element("span", {}, "Body"), follow));
    if (view.quantities.length > 1) {
      const exaggerate = (factor: number) => {
        this.exaggeration = factor;
        view.exaggerate(factor);
        this.showScale();
      };
      row.append(factorSlider("Exaggeration", 1, largestFactor, 1, exaggerate));
      const options = view.quantities.map((value) => ({ value, text: quantityNames[value] }));
      const asked = new URLSearchParams(location.hash.slice(1)).get("color") as Quantity;
      row.append(choice("Colour", options, view.quantities.includes(asked) ? asked : "displacement", (quantity) => this.colorBy(view, quantity)));
      const again = element("button", { title: "Restart the colour scale" }, "New scale");
      again.addEventListener("click", () => this.colorBy(view, this.quantity));
      row.append(again);
    } else this.showScale();
    if (this.scene.bodies.some((body) => body.shapes.length > 0)) row.append(checkbox("See through solids", view.hidesFlexible(), (on) => view.seeThrough(on)));
    if (this.scene.elements.some(({ kind }) => kind !== "load" && !kind.startsWith("tyre")))
      row.append(checkbox("Joints and springs", true, (on) => view.showElements(on)));
    const fine = checkbox("Shadows and full resolution", true, (on) => view.refine(on));
    fine.title = "Turned off automatically where drawing is slow";
    this.fine = fine.querySelector("input");
    row.append(fine);
    this.forces = new ForcePanel(view, () => this.needed());
    row.append(...this.forces.parts);
    this.forces.parts[0]?.addEventListener("change", () => this.needed());
    const fit = element("button", { title: "Show all bodies" }, "Fit view");
    fit.addEventListener("click", () => this.look(view, this.camera));
    const picture = element("button", { title: "Save the picture as PNG" }, "Save picture");
    picture.addEventListener("click", () => {
      view.redraw();
      saveCanvas(view.canvas, `t${this.clock.text().replace(" ", "")}`);
    });
    row.append(fit, picture);
    return element("details", { class: "viewing" }, element("summary", {}, "View"), row);
  }

  /** Turns shadows off and the resolution down where drawing is too slow. */
  private saveWork(now: number): void {
    const { watched, fine } = this;
    ++watched.drawn;
    const passed = now - watched.since;
    if (passed < patience) return;
    const each = passed / watched.drawn;
    // Of a page that was hidden nothing is known.
    if (fine?.checked && each > slow && watched.drawn > 2 && this.view?.ready) fine.click();
    this.watched = { since: now, drawn: 0 };
  }

  private look(view: View3D, camera: Camera): void {
    this.camera = camera;
    view.follow(camera === "still" ? -1 : this.leader);
  }

  /** From where the chasing eye looks. */
  private behind(): THREE.Vector3 | null {
    if (this.camera !== "chase") return null;
    const [w, x, y, z] = this.scene.animation.rotations.subarray(4 * this.leader);
    this.seen = heading(w, x, y, z);
    return new THREE.Vector3(-Math.cos(this.seen), -Math.sin(this.seen), 0.42).normalize();
  }

  /** The eye turns with the body, softly. */
  private chase(view: View3D, { later }: Between, now: number): void {
    const [w, x, y, z] = later.rotations.subarray(4 * this.leader);
    const turn = turnBetween(this.seen, heading(w, x, y, z));
    if (!Number.isFinite(turn) || Math.abs(turn) < 1e-5) return;
    const part = (1 - Math.exp((this.shown - now) / lag)) * turn;
    this.seen += part;
    view.turn(part, 0);
  }

  private colorBy(view: View3D, quantity: Quantity): void {
    this.quantity = quantity;
    this.ends = this.ends.map(() => 0);
    this.rescale(view, true);
  }

  /** The scale grows with what is seen. */
  private rescale(view: View3D, anew = false): void {
    if (this.quantity !== "none") {
      const largest = Math.max(0, ...this.scene.bodies.map((body, k) => (has(body, this.quantity) ? view.largestNow(k, this.quantity).value : 0)));
      const end = Math.max(this.ends[0] ?? 0, niceAbove(largest));
      if (end === this.ends[0] && !anew) return;
      this.ends = this.ends.map(() => end);
    } else if (!anew) return;
    view.colorUpTo(this.quantity, this.ends);
    this.showScale();
  }

  private showScale(): void {
    this.note.textContent = viewNote(this.view?.cell ?? 1, this.exaggeration);
    if (this.quantity === "none") return this.bar.hide();
    const end = this.ends[0] ?? 0;
    this.bar.show(this.quantity, end, end > 0 ? "The scale covers the largest so far" : "");
  }
}
