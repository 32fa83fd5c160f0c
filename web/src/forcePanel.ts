// Which forces are drawn as arrows, and how long: loads, and the reactions of the joints that are ticked.
import { type Shown } from "./arrows";
import type { Element } from "./data";
import { element } from "./dom";
import { scaleFor } from "./engineering";
import { choice, factorSlider } from "./slider";
import { quantity } from "./summaryLines";
import type { View3D } from "./view3d";

export class ForcePanel {
  /** Empty where there are no forces. */
  readonly parts: HTMLElement[] = [];
  private shown: Shown = "none";
  private factor = 1;
  private slider?: HTMLElement; // of the arrows' scale
  private list = element("details", { class: "reactions" });
  private refreshers: (() => void)[] = [];

  constructor(
    private view: View3D,
    /** Other reactions are ticked. */
    private changed: () => void,
  ) {
    const { arrows } = view;
    if (!arrows.hasLoads && !arrows.hasReactions) return;
    // In the unit in which lengths of this size are read.
    const length = scaleFor("m", 10 * view.size);
    const slider = factorSlider(`Arrow of 1 ${length.unit}`, 0.01, 100, 1, (by) => this.draw((this.factor = by)), (by) => {
      const { force, moment } = arrows.perMetre;
      const shown = by * length.size;
      return [force > 0 ? quantity(shown * force, "N") : "", moment > 0 ? `${quantity(shown * moment, "N m")} (two heads)` : ""].filter((text) => text !== "").join(", ");
    });
    slider.classList.add("wide");
    this.slider = slider;
    const asked = new URLSearchParams(location.hash.slice(1)).get("forces") as Shown | null;
    const options: { value: Shown; text: string }[] = [{ value: "none", text: "off" }];
    if (arrows.hasLoads) options.push({ value: "loads", text: "loads" });
    if (arrows.hasReactions) options.push({ value: "all", text: arrows.hasLoads ? "loads and reactions" : "reactions" });
    const start = options.some(({ value }) => value === asked) ? asked! : arrows.hasLoads ? "loads" : "none";
    this.fill();
    const chosen = choice("Forces", options, start, (value) => {
      this.shown = value;
      slider.hidden = value === "none";
      this.list.hidden = value !== "all";
      this.draw();
      this.refreshScale();
    });
    chosen.title = "Red: loads and drag. Blue: forces of joints on their second body and of tyres on wheels. Violet with two heads: moments.";
    this.parts = [chosen, slider, this.list];
  }

  /** A joint or tyre whose reaction can be ticked now. */
  offers(of: Element): boolean {
    return this.shown === "all" && this.view.arrows.reacting.includes(of);
  }

  ticked(of: Element): boolean {
    return this.view.arrows.chosen.has(of);
  }

  tick(of: Element, on: boolean): void {
    const { chosen } = this.view.arrows;
    if (on) chosen.add(of);
    else chosen.delete(of);
    this.refresh();
  }

  private fill(): void {
    const { reacting, chosen } = this.view.arrows;
    const button = (text: string, all: boolean) => {
      const made = element("button", { type: "button" }, text);
      made.addEventListener("click", () => {
        for (const one of reacting) if (all) chosen.add(one);
        else chosen.delete(one);
        this.refresh();
      });
      return made;
    };
    const boxes = reacting.map((one) => {
      const box = element("input", { type: "checkbox" });
      this.refreshers.push(() => (box.checked = chosen.has(one)));
      box.addEventListener("change", () => this.tick(one, box.checked));
      return element("label", { title: one.kind }, box, element("span", {}, one.name));
    });
    const title = element("summary");
    this.refreshers.push(() => (title.textContent = `${chosen.size} of ${reacting.length} reactions`));
    title.title = "Tick the reactions to draw, here or after a click on a joint in the picture. At first the largest are ticked";
    this.list.append(title, element("div", { class: "row" }, button("All", true), button("None", false)), element("div", { class: "ticks" }, ...boxes));
    this.refresh();
  }

  /** What the arrows stand for may have changed. */
  refreshScale(): void {
    this.slider?.querySelector("input")!.dispatchEvent(new Event("input"));
  }

  private refresh(): void {
    for (const refresher of this.refreshers) refresher();
    this.draw();
    this.changed();
  }

  private draw(factor = this.factor): void {
    this.view.showArrows(this.shown, factor);
  }
}
