// Stacked plots, one per unit, with one time axis: cursors and zoom go together.
import type uPlot from "uplot";
import uPlotJoin from "uplot";
import { Chart } from "./chart";
import type { Clock } from "./clock";
import { element, onThemeChange } from "./dom";
import { onSecondAxis, scaleFor, type Scale } from "./engineering";
import { figure } from "./figure";
import { formatWithin } from "./format";
import { unitLabel } from "./groups";
import { valueAt } from "./interpolate";
import { byUnit, largest, scaled, type Curves, type Range, type Trace } from "./trace";

interface Plot {
  chart: Chart;
  values: HTMLElement[];
  traces: Trace[];
  scales: Scale[];
}

const height = 190;

/** A way to look at the chosen channels. */
export interface View {
  root: HTMLElement;
  show(selection: number[]): void;
}

export class Plots implements View {
  readonly root = element("div", { class: "plots" });
  private plots: Plot[] = [];
  private selection: number[] = [];
  private gutters = { left: 0, right: 0 };
  private range: Range | null = null; // of the time axis, null when all is shown

  constructor(
    private curves: Curves,
    private whole: Range,
    private clock: Clock,
    private remove: (channel: number) => void,
  ) {
    clock.onChange(() => this.follow());
    onThemeChange(() => this.show(this.selection));
    new ResizeObserver(() => this.resize()).observe(this.root);
  }

  show(selection: number[]): void {
    this.selection = selection;
    for (const { chart } of this.plots) chart.uplot.destroy();
    this.root.replaceChildren();
    const traces = this.curves.traces(selection).filter(({ time }) => time.length > 0);
    if (traces.length === 0) {
      const why = selection.length > 0 ? "The results contain no instants." : "No channel is selected. Tick some in the list.";
      this.root.append(element("p", { class: "hint" }, why));
    }
    this.gutters = { left: 0, right: 0 };
    this.plots = [...byUnit(traces)].map(([unit, of]) => this.plot(unit, of));
    if (this.plots.length > 1) for (const { chart } of this.plots) chart.align();
    this.follow();
  }

  /** The part of the time that is shown. */
  get visible(): Range {
    return this.range ?? this.whole;
  }

  resetZoom(): void {
    for (const { chart } of this.plots) chart.uplot.setScale("x", this.whole);
    this.range = null;
  }

  private plot(unit: string, traces: Trace[]): Plot {
    const second = onSecondAxis(traces.map(({ range }) => range));
    const scaleOf = (right: boolean) => scaleFor(unit, Math.max(0, ...traces.filter((_, k) => second[k] === right).map(({ values }) => largest(values))));
    const [left, right] = [scaleOf(false), scaleOf(true)];
    const scales = traces.map((_, k) => (second[k] ? right : left));
    const title = second.includes(true) && left.unit !== right.unit ? `${unitLabel(left.unit)}, ${unitLabel(right.unit)}` : unitLabel(left.unit);
    const made = figure(title, "Plot over time", traces, this.remove, second);
    this.root.append(made.root);
    let plot: Plot | undefined = undefined; // the chart may call back before it is there
    const together = traces.every(({ time }) => time === traces[0].time);
    const columns = traces.map(({ values }, k) => scaled(values, scales[k].size));
    const chart = new Chart(made.holder, {
      width: Math.max(this.root.clientWidth, 200),
      height,
      range: this.visible,
      unit: "s",
      data: together ? ([traces[0].time, ...columns] as uPlot.AlignedData) : uPlotJoin.join(traces.map(({ time }, k) => [time, columns[k]] as uPlot.AlignedData)),
      lines: traces.map(({ color }, k) => ({ color, second: second[k] })),
      units: [unitLabel(left.unit), unitLabel(right.unit)],
      key: "time",
      gutters: this.gutters,
      clock: this.clock,
      pointed: () => this.readOut(plot),
      zoomed: (range) => (this.range = range),
    });
    plot = { chart, values: made.values, traces, scales };
    return plot;
  }

  /** The marker and the values in the legends go with the animation's time. */
  private follow(): void {
    for (const plot of this.plots) {
      plot.chart.place();
      this.readOut(plot);
    }
  }

  /** Values under the cursor; where there is none, those at the animation's time. */
  private readOut(plot: Plot | undefined): void {
    if (!plot) return;
    const { cursor, data } = plot.chart.uplot;
    const t = cursor.idx == null ? this.clock.time : data[0][cursor.idx];
    plot.traces.forEach(({ time, values, range }, k) => {
      const value = valueAt(time, values, t);
      const { size, unit } = plot.scales[k];
      // Round-off beside curves that change much is shown as zero.
      const widest = Math.max(...plot.traces.filter((_, other) => plot.scales[other] === plot.scales[k]).map((other) => other.range));
      plot.values[k].textContent = value === null ? "–" : `${formatWithin(Math.max(range, 1e-4 * widest) / size, value / size)} ${unit === "1" ? "" : unit}`.trim();
    });
  }

  private resize(): void {
    const width = Math.max(this.root.clientWidth, 200);
    for (const { chart } of this.plots) if (chart.uplot.width !== width) chart.uplot.setSize({ width, height });
    this.follow();
  }
}
