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
    /** What is ticked has changed. */
    private changed: () => void,
  ) {
    const { arrows } = view;
    if (!arrows.hasLoads && !arrows.hasReactions) return;
    // As long as things of this size are told in.
    const length = scaleFor("m", 10 * view.size);
    const slider = factorSlider(`1 ${length.unit} is`, 0.01, 100, 1, (by) => this.draw((this.factor = by)), (by) => {
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
      this.tellScale();
    });
    chosen.title = "Red: loads, and drag. Blue: what joints exert on their second bodies, and tyres on wheels. Violet, two heads: moments.";
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
    this.refreshers.push(() => (title.textContent = `Reactions of ${chosen.size} of ${reacting.length}`));
    title.title = "Tick those whose arrows are drawn, here or by a click on a joint in the picture; at first those with the largest forces";
    this.list.append(title, element("div", { class: "row" }, button("All", true), button("None", false)), element("div", { class: "ticks" }, ...boxes));
    this.refresh();
  }

  /** What the arrows stand for may have changed. */
  tellScale(): void {
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
