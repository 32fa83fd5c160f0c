// The chosen curves over another one instead of over time.
import uPlot from "uplot";
import { axisStyle, axisWidth } from "./chart";
import type { Clock } from "./clock";
import { element, onThemeChange } from "./dom";
import { scaleFor, tickLabels } from "./engineering";
import { figure } from "./figure";
import { unitLabel } from "./groups";
import { valueAt } from "./interpolate";
import type { View } from "./plots";
import { checkbox } from "./slider";
import { byUnit, magnitude, scaled, type Curves, type Range, type Trace } from "./trace";

const height = 340;

interface Plot {
  chart: uPlot;
  dots: { trace: Trace; x: Trace; dot: HTMLElement }[];
  sizes: [x: number, y: number];
}

interface Zoom {
  x: [number, number];
  y: [number, number];
}

/** Smallest and largest of the finite values, with a margin; never empty. */
export function paddedRange(values: Iterable<number | null>, margin = 0.05): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value === null) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (!(low <= high)) return [0, 1];
  const pad = high > low ? margin * (high - low) : Math.max(Math.abs(low), 1) * margin;
  return [low - pad, high + pad];
}

export class XyPlot implements View {
  readonly root = element("div", { class: "plots" });
  private holder = element("div");
  private across = element("select", { "aria-label": "Channel on the horizontal axis" });
  private plots: Plot[] = [];
  private selection: number[] = [];
  private equal = false;
  private zooms = new Map<string, Zoom>(); // of the plots of a unit, in the channels' own units

  constructor(
    private curves: Curves,
    private visible: () => Range,
    private clock: Clock,
    private remove: (channel: number) => void,
  ) {
    const again = () => this.show(this.selection);
    this.across.addEventListener("change", () => {
      this.zooms.clear();
      again();
    });
    const equal = checkbox("Equal scales", false, (on) => {
      this.equal = on;
      this.zooms.clear();
      if (this.plots.length > 0) again();
    });
    equal.title = "One scale for both axes where they have the same unit";
    this.root.append(element("div", { class: "settings" }, element("label", {}, element("span", {}, "Over"), this.across), equal), element("p", { class: "hint" }, "Drag a rectangle in a plot to zoom, double-click to show all."), this.holder);
    clock.onChange(() => this.follow());
    onThemeChange(again);
    new ResizeObserver(() => this.plots.length > 0 && this.plots[0].chart.width !== this.width && again()).observe(this.root);
  }

  resetZoom(): void {
    this.zooms.clear();
    this.show(this.selection);
  }

  show(selection: number[]): void {
    this.selection = selection;
    this.fillChoice();
    for (const { chart } of this.plots) chart.destroy();
    this.plots = [];
    this.holder.replaceChildren();
    const x = Number(this.across.value);
    const over = this.curves.traces([x]);
    const traces = this.curves.traces(selection.filter((channel) => channel !== x)).filter(({ run }) => over.some((one) => one.run === run));
    if (traces.length === 0) this.holder.append(element("p", { class: "hint" }, "Tick the channels to plot over this one in the list."));
    for (const [unit, of] of byUnit(traces)) this.plot(unit, of, over);
    this.follow();
  }

  private get width(): number {
    return Math.max(this.root.clientWidth, 200);
  }

  /** The channels with the chosen ones first; the first of them is on the axis until another is asked for. */
  private fillChoice(): void {
    const known = this.across.value === "" ? -1 : Number(this.across.value);
    const rest = [...this.curves.channels.keys()].filter((channel) => !this.selection.includes(channel));
    this.across.replaceChildren(...[...this.selection, ...rest].map((channel) => element("option", { value: channel }, this.curves.channels[channel].name)));
    this.across.value = String(known >= 0 ? known : (this.selection[0] ?? rest[0] ?? ""));
  }

  private plot(unit: string, traces: Trace[], over: Trace[]): void {
    const { min, max } = this.visible();
    const xOf = (trace: Trace) => over.find(({ run }) => run === trace.run)!;
    const xScale = scaleFor(over[0].unit, Math.max(...over.map((one) => magnitude(one, min, max))));
    const yScale = scaleFor(unit, Math.max(...traces.map((one) => magnitude(one, min, max))));
    const inside = ({ time }: Trace, values: (number | null)[]) => values.map((value, i) => (time[i] >= min && time[i] <= max ? value : null));
    const data = traces.map((trace) => {
      const x = xOf(trace);
      const own = x.time === trace.time ? x.values : trace.time.map((t) => valueAt(x.time, x.values, t));
      return [inside(trace, scaled(own, xScale.size)), inside(trace, scaled(trace.values, yScale.size))];
    });
    const { root, holder } = figure(unitLabel(yScale.unit), `Plot over ${over[0].name}`, traces, this.remove);
    this.holder.append(root);
    let xRange = paddedRange(data.flatMap(([x]) => x));
    let yRange = paddedRange(data.flatMap(([, y]) => y));
    if (this.equal && over[0].unit === unit) [xRange, yRange] = this.sameScale(xRange, yRange, xScale.size, yScale.size);
    const sizes: Plot["sizes"] = [xScale.size, yScale.size];
    const times = (range: [number, number], size: number) => range.map((value) => value * size) as [number, number];
    const known = this.zooms.get(unit);
    if (known) [xRange, yRange] = [times(known.x, 1 / sizes[0]), times(known.y, 1 / sizes[1])];
    /** To the rectangle that was drawn, or back to all. */
    const zoom = (u: uPlot | null) => {
      if (u) {
        const { left, top, width, height } = u.select;
        const along = (scale: string, from: number, to: number, size: number) => times([u.posToVal(from, scale), u.posToVal(to, scale)], size);
        this.zooms.set(unit, { x: along("x", left, left + width, sizes[0]), y: along("y", top + height, top, sizes[1]) });
      } else if (!this.zooms.delete(unit)) return;
      setTimeout(() => this.show(this.selection)); // not from within the chart that goes
    };
    const axis = axisStyle();
    const chart = new uPlot(
      {
        mode: 2,
        width: this.width,
        height,
        legend: { show: false },
        cursor: { drag: { x: true, y: true, dist: 5, setScale: false }, points: { show: false }, bind: { dblclick: () => () => (zoom(null), null) } },
        hooks: {
          draw: [() => this.follow()], // scales are known from the first drawing on
          setSelect: [(u) => u.select.width > 0 && u.select.height > 0 && zoom(u)],
        },
        scales: { x: { time: false, range: () => xRange }, y: { range: () => yRange } },
        series: [
          null as unknown as uPlot.Series,
          ...traces.map(({ color }) => ({ stroke: color, facets: [{ scale: "x" }, { scale: "y" }], paths: (u: uPlot, k: number) => drawLine(u, k, color) }) as unknown as uPlot.Series),
        ],
        axes: [
          { ...axis, size: 34, label: `${over[0].name}, ${unitLabel(xScale.unit)}`, values: (_, splits) => tickLabels(splits) },
          { ...axis, size: axisWidth as uPlot.Axis.Size, label: unitLabel(yScale.unit), values: (_, splits) => tickLabels(splits) },
        ],
      },
      [null, ...data] as unknown as uPlot.AlignedData,
      holder,
    );
    const dots = traces.map((trace) => {
      const dot = element("div", { class: "dot" });
      dot.style.background = trace.color;
      chart.over.append(dot);
      return { trace, x: xOf(trace), dot };
    });
    this.plots.push({ chart, dots, sizes });
  }

  /** The larger of both metres per pixel for both axes. */
  private sameScale(x: [number, number], y: [number, number], xSize: number, ySize: number): [[number, number], [number, number]] {
    const per = Math.max(((x[1] - x[0]) * xSize) / (this.width - 110), ((y[1] - y[0]) * ySize) / (height - 70));
    const about = ([low, high]: [number, number], half: number): [number, number] => [(low + high) / 2 - half, (low + high) / 2 + half];
    return [about(x, (per * (this.width - 110)) / 2 / xSize), about(y, (per * (height - 70)) / 2 / ySize)];
  }

  /** Dots at the animation's time. */
  private follow(): void {
    for (const { chart, dots, sizes } of this.plots)
      for (const { trace, x, dot } of dots) {
        const [u, v] = [valueAt(x.time, x.values, this.clock.time), valueAt(trace.time, trace.values, this.clock.time)];
        dot.hidden = u === null || v === null;
        if (u === null || v === null) continue;
        const [left, top] = [chart.valToPos(u / sizes[0], "x"), chart.valToPos(v / sizes[1], "y")];
        dot.hidden = !(left >= 0 && left <= chart.over.clientWidth && top >= 0 && top <= chart.over.clientHeight);
        dot.style.transform = `translate(${left}px, ${top}px)`;
      }
  }
}

function drawLine(u: uPlot, k: number, color: string): null {
  const [xs, ys] = u.data[k] as unknown as (number | null)[][];
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.beginPath();
  let on = false;
  xs.forEach((x, i) => {
    const y = ys[i];
    if (x === null || y === null) {
      on = false;
      return;
    }
    const [px, py] = [u.valToPos(x, "x", true), u.valToPos(y, "y", true)];
    if (on) ctx.lineTo(px, py);
    else ctx.moveTo(px, py);
    on = true;
  });
  ctx.strokeStyle = color;
  ctx.lineWidth = 1.5 * devicePixelRatio;
  ctx.lineJoin = "round";
  ctx.stroke();
  ctx.restore();
  return null;
}
