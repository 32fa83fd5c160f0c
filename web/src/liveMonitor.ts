// Whether the steps meet their deadlines: the last step, the distribution of all, and the causes of late steps.
import { element } from "./dom";
import { formatNumber } from "./format";
import type { Spread, Status } from "./liveProtocol";
import { quantity } from "./summaryLines";

const columns: [keyof Spread, string][] = [
  ["median", "median"],
  ["p99", "99 %"],
  ["p9999", "99.99 %"],
  ["worst", "worst"],
];

const causes: [string, string][] = [
  ["computation", "computation of the step"],
  ["latency", "late wake-up"],
  ["preemption", "preempted by other work"],
  ["page_faults", "page faults"],
  ["parts", "step split into parts"],
  ["iterations", "many iterations"],
];

const shape = <K extends keyof SVGElementTagNameMap>(tag: K, attributes: Record<string, string | number>): SVGElementTagNameMap[K] => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  return made;
};

/** Heights of bars from 0 to 1 by the logarithm: one late step in a million is to be seen. */
export function heights(counts: number[]): number[] {
  const most = Math.log10(1 + Math.max(0, ...counts));
  return counts.map((count) => (count > 0 ? Math.max(Math.log10(1 + count) / most, 0.04) : 0));
}

/** Of a time on an axis over edges that grow by equal factors, 0 to 1. */
export function alongEdges(edges: number[], time: number): number {
  const [first, last] = [Math.log(edges[0]), Math.log(edges[edges.length - 1])];
  return (Math.log(time) - first) / (last - first);
}

export class Monitor {
  readonly root: HTMLElement;
  private load = element("div", { class: "load-fill" });
  private peak = element("div", { class: "load-peak" });
  private meter = element("div", { class: "load", role: "meter", "aria-label": "Computing time of the last step as a share of its length", "aria-valuemin": 0, "aria-valuemax": 100 }, this.load, this.peak);
  private share = element("span", { class: "share" });
  private cells = new Map<string, HTMLElement>();
  private overruns = element("p", { class: "overruns" });
  private causes = element("ul", { class: "causes" });
  private histogram = shape("svg", { viewBox: "0 0 400 96", role: "img", preserveAspectRatio: "none", class: "histogram" });
  private axis = element("div", { class: "histogram-axis" });
  private facts = element("dl", { class: "facts" });
  private most = 0; // of the shares in the last seconds
  private sinceUpdate = 0; // s

  constructor() {
    const rows = (["computation", "cpu", "latency"] as const).map((key) =>
      element(
        "tr",
        {},
        element("th", { scope: "row" }, { computation: "Computation", cpu: "of which CPU time", latency: "Late start" }[key]),
        ...columns.map(([column]) => {
          const cell = element("td", {}, "–");
          this.cells.set(`${key}.${column}`, cell);
          return cell;
        }),
      ),
    );
    const table = element("table", { class: "spread" }, element("thead", {}, element("tr", {}, element("td"), ...columns.map(([, name]) => element("th", { scope: "col" }, name)))), element("tbody", {}, ...rows));
    const swatch = (name: string, text: string) => element("span", { class: "entry" }, element("span", { class: `swatch ${name}` }), text);
    this.root = element(
      "section",
      { class: "card monitor" },
      element("h2", {}, "Deadlines"),
      element("div", { class: "row" }, element("span", { class: "muted" }, "Last step"), this.meter, this.share),
      this.overruns,
      this.causes,
      element("div", { class: "scroll-x" }, table),
      element("figure", {}, element("figcaption", {}, element("div", { class: "legend" }, swatch("computing", "computation"), swatch("late", "latency"), swatch("limit", "deadline"), element("small", { class: "muted" }, "number of steps, logarithmic scale"))), this.histogram, this.axis),
      element("details", { class: "all" }, element("summary", {}, "Details"), this.facts),
    );
  }

  /** `share`: the last step's computation over its length. */
  tick(share: number, dt: number): void {
    this.most = Math.max(share, this.most - 0.15 * dt);
    const part = (value: number) => `${Math.min(Math.max(100 * value, 0), 100)}%`;
    this.load.style.width = part(share);
    this.peak.style.left = part(this.most);
    this.meter.classList.toggle("over", this.most > 1);
    this.sinceUpdate += dt;
    if (this.sinceUpdate < 0.25) return; // readable, and not too often for a screen reader
    this.sinceUpdate = 0;
    this.share.textContent = `${formatNumber(100 * share, 2)} %`;
    this.meter.setAttribute("aria-valuenow", String(Math.min(Math.round(100 * share), 100)));
    this.meter.setAttribute("aria-valuetext", `${Math.round(100 * share)} % of the step`);
  }

  show(status: Status): void {
    for (const key of ["computation", "cpu", "latency"] as const)
      for (const [column] of columns) {
        const value = status[key][column];
        const cell = this.cells.get(`${key}.${column}`)!;
        cell.textContent = Number.isFinite(value) ? quantity(value, "s", 3) : "–";
        cell.classList.toggle("bad", key === "computation" && value * status.speed > status.step);
      }
    const { count = 0, skipped_outputs: skipped = 0, lag = 0 } = status.overruns;
    this.overruns.textContent = `${count === 0 ? "No step was late" : `${formatNumber(count)} of ${formatNumber(status.steps)} steps ${count === 1 ? "was" : "were"} late`}${skipped > 0 ? `; ${formatNumber(skipped)} ${skipped === 1 ? "output was" : "outputs were"} skipped` : ""}${lag > status.step ? `; ${quantity(lag, "s")} behind the clock` : ""}.`;
    this.overruns.classList.toggle("bad", count > 0);
    const known = causes.filter(([key]) => (status.overruns[key] ?? 0) > 0);
    this.causes.replaceChildren(...known.map(([key, text]) => element("li", {}, `${formatNumber(status.overruns[key])} × ${text}`)));
    this.draw(status);
    const facts: [string, string][] = [
      ["Step", `${quantity(status.step, "s")}${status.speed !== 1 ? `, at ${formatNumber(status.speed)}× real time` : ""}`],
      ["Iterations", `${formatNumber(status.iterations.mean, 3)} on average, ${status.iterations.most} at most`],
      ["Bound", status.worst_case],
      ["Scheduling", status.clock.scheduling],
      ["Memory", status.clock.memory],
      ["Processor", status.clock.cpu],
    ];
    this.facts.replaceChildren(...facts.flatMap(([name, text]) => [element("dt", {}, name), element("dd", {}, text)]));
  }

  /** The part of the histogram that holds something, and the deadline. */
  private draw({ histogram: { edges, computation, latency }, step, speed }: Status): void {
    const filled = edges.slice(1).map((edge, k) => (computation[k] ?? 0) + (latency[k] ?? 0) > 0 || (edges[k] <= step / speed && edge >= step / speed));
    const from = Math.max(filled.indexOf(true) - 1, 0);
    const to = Math.min(filled.lastIndexOf(true) + 2, edges.length - 1);
    const shown = edges.slice(from, to + 1);
    if (shown.length < 2) return;
    const bars = (counts: number[], name: string) => {
      const width = 400 / (shown.length - 1);
      return heights(counts.slice(from, to)).map((height, k) => shape("rect", { x: k * width + 0.5, y: 92 - 88 * height, width: Math.max(width - 1, 0.5), height: 88 * height, class: name }));
    };
    const limit = 400 * alongEdges(shown, step / speed);
    this.histogram.replaceChildren(...bars(latency, "late"), ...bars(computation, "computing"), shape("line", { x1: 0, x2: 400, y1: 92, y2: 92, class: "ground" }), shape("line", { x1: limit, x2: limit, y1: 0, y2: 92, class: "limit" }));
    this.histogram.setAttribute("aria-label", "Histogram of computation and latency, with the deadline");
    const marks: number[] = [];
    for (let power = Math.ceil(Math.log10(shown[0]) - 1e-9); power <= Math.log10(shown[shown.length - 1]) + 1e-9; ++power) marks.push(10 ** power);
    this.axis.replaceChildren(
      ...marks.map((mark) => {
        const label = element("span", {}, quantity(mark, "s", 2));
        label.style.left = `${100 * alongEdges(shown, mark)}%`;
        return label;
      }),
    );
  }
}
