// Smallest, largest, mean and root-mean-square values of the chosen curves, and what each curve is.
import { element } from "./dom";
import { scaleFor } from "./engineering";
import { formatWithin } from "./format";
import { unitLabel } from "./groups";
import type { View } from "./plots";
import { statistics } from "./statistics";
import { instant } from "./summaryLines";
import { magnitude, type Curves, type Range } from "./trace";

export class StatisticsTable implements View {
  readonly root = element("div", { class: "plots" });

  constructor(
    private curves: Curves,
    private visible: () => Range,
    private thinned: boolean,
  ) {}

  show(selection: number[]): void {
    const { min, max } = this.visible();
    const heads = ["Channel", "Unit", "Minimum", "Maximum", "Mean", "RMS"].map((title) => element("th", { scope: "col" }, title));
    const rows = this.curves.traces(selection).map((trace) => {
      const { unit, size } = scaleFor(trace.unit, magnitude(trace, min, max));
      const found = statistics(trace.time, trace.values, min, max);
      const number = (value: number) => formatWithin(trace.range / size, value / size);
      const at = (value: number, t: number) => element("td", {}, number(value), element("small", {}, ` at ${instant(t)}`));
      const cells = found
        ? [at(found.min, found.minAt), at(found.max, found.maxAt), element("td", {}, number(found.mean)), element("td", {}, number(found.rms))]
        : [element("td", { colspan: 4 }, "no value")];
      const swatch = element("span", { class: "swatch" });
      swatch.style.setProperty("--line", trace.color);
      const name = element("th", { scope: "row" }, swatch, trace.label, element("small", { class: "meaning" }, trace.meaning));
      return element("tr", {}, name, element("td", {}, unitLabel(unit)), ...cells);
    });
    const note = `From ${instant(min, 5)} to ${instant(max, 5)}, the interval that the plots show.${this.thinned ? " Mean and RMS are those of the thinned record in this page." : ""}`;
    const table = element("div", { class: "scroll" }, element("table", { class: "wide statistics" }, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...rows)));
    this.root.replaceChildren(element("p", { class: "hint" }, rows.length > 0 ? note : "No channel is selected. Tick some in the list."), ...(rows.length > 0 ? [table] : []));
  }
}
