// The frame around a chart: unit, legend, place of the chart.
import { element } from "./dom";
import type { Trace } from "./trace";

export interface Figure {
  root: HTMLElement;
  holder: HTMLElement;
  /** Of each curve, for its value at the cursor. */
  values: HTMLElement[];
}

export function figure(title: string, what: string, traces: Trace[], remove: (channel: number) => void, second: boolean[] = []): Figure {
  const values: HTMLElement[] = [];
  const entries = traces.map((trace, k) => {
    const value = element("span", { class: "value" });
    values.push(value);
    const swatch = element("span", { class: second[k] ? "swatch dashed" : "swatch" });
    swatch.style.setProperty("--line", trace.color);
    const close = element("button", { class: "close", "aria-label": `Remove ${trace.name}`, title: "Remove" }, "×");
    close.addEventListener("click", () => remove(trace.channel));
    const side = second[k] ? [element("small", {}, "right axis")] : [];
    return element("span", { class: "entry", title: trace.meaning }, swatch, trace.label, ...side, value, close);
  });
  const holder = element("div", { class: "chart", role: "img", "aria-label": `${what} of ${traces.map(({ label }) => label).join(", ")}` });
  const caption = element("figcaption", {}, element("b", {}, title), element("div", { class: "legend" }, ...entries));
  return { root: element("figure", {}, caption, holder), holder, values };
}
