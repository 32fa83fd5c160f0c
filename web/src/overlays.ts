// Per channel one plot with all runs over each other, and below it what they differ by from the first.
import uPlot from "uplot";
import { Chart } from "./chart";
import type { Clock } from "./clock";
import { lineColors } from "./color";
import type { ComparedChannel, Comparison } from "./comparisonData";
import type { Curve } from "./data";
import { element, onThemeChange } from "./dom";
import { scaleFor } from "./engineering";
import { formatWithin } from "./format";
import { unitLabel } from "./groups";
import { valueAt } from "./interpolate";
import { extent, overlayRange } from "./overlayRange";
import type { View } from "./plots";
import { endOf, isSound } from "./runFacts";
import { largest, scaled, type Range } from "./trace";

interface Line {
  run: number;
  time: number[];
  curve: Curve;
  value: HTMLElement;
}

interface Plot {
  chart: Chart;
  lines: Line[];
  size: number; // of the unit shown in the channel's
  unit: string;
  height: number;
}

const valuesHeight = 190;
const differencesHeight = 130;

export function runColor(run: number): string {
  return lineColors[run % lineColors.length];
}

export class Overlays implements View {
  readonly root = element("div", { class: "plots" });
  private plots: Plot[] = [];
  private selection: number[] = [];
  private gutters = { left: 0, right: 0 };
  readonly hidden = new Set<number>();
  private differences = true;
  private range: Range | null = null; // of the time axis, null when all is shown

  constructor(
    private comparison: Comparison,
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
    this.plots = [];
    if (selection.length === 0) this.root.append(element("p", { class: "hint" }, "No channel is selected. Tick some in the list."));
    this.gutters = { left: 0, right: 0 };
    for (const index of selection) this.add(index);
    if (this.plots.length > 1) for (const { chart } of this.plots) chart.align();
    this.follow();
  }

  showRun(run: number, visible: boolean): void {
    if (visible) this.hidden.delete(run);
    else this.hidden.add(run);
    for (const plot of this.plots) plot.lines.forEach((line, k) => line.run === run && plot.chart.uplot.setSeries(k + 1, { show: visible }));
    this.follow();
  }

  showDifferences(visible: boolean): void {
    this.differences = visible;
    this.show(this.selection);
  }

  /** The part of the time that is shown. */
  get visible(): Range {
    return this.range ?? this.whole();
  }

  resetZoom(): void {
    for (const { chart } of this.plots) chart.uplot.setScale("x", this.whole());
  }

  private whole(): Range {
    const runs = this.comparison.runs.filter((run) => run.time.length > 0);
    return { min: Math.min(...runs.map((run) => run.time[0])), max: Math.max(...runs.map(endOf)) };
  }

  private add(index: number): void {
    const { runs, channels } = this.comparison;
    const channel = channels[index];
    const close = element("button", { class: "close", "aria-label": `Remove ${channel.name}`, title: "Remove" }, "×");
    close.addEventListener("click", () => this.remove(index));
    const title = element("b", { title: channel.meaning }, channel.name);
    this.plot(channel, channel.curves, (run) => runs[run].time, valuesHeight, [title, close], "Plot over time");
    if (!this.differences) return;
    const caption = element("span", { class: "versus" }, `minus ${runs[0].label}`);
    const most = (curves: (Curve | null)[]) => Math.max(0, ...curves.map((curve) => (curve ? largest(curve.values) : 0)));
    if (channel.differences.some((curve) => curve) && most(channel.differences) <= 1e-12 * most(channel.curves)) {
      this.root.append(element("p", { class: "hint" }, `Equal to ${runs[0].label} within round-off.`));
      return;
    }
    this.plot(channel, channel.differences, (run) => runs[run].commonTime, differencesHeight, [caption], `Differences to ${runs[0].label}`);
  }

  private plot(channel: ComparedChannel, curves: (Curve | null)[], time: (run: number) => number[], height: number, caption: Node[], what: string): void {
    const { runs } = this.comparison;
    const lines = curves.flatMap((curve, run): Line[] =>
      curve && time(run).length > 0 ? [{ run, time: time(run), curve, value: element("span", { class: "value" }) }] : [],
    );
    if (lines.length === 0) return;
    const entries = lines.map(({ run, value }) => {
      const swatch = element("span", { class: "swatch" });
      swatch.style.setProperty("--line", runColor(run));
      return element("span", { class: "entry", title: runs[run].label }, swatch, value);
    });
    const holder = element("div", { role: "img", "aria-label": `${what} of ${channel.name}` });
    this.root.append(element("figure", {}, element("figcaption", {}, ...caption, element("div", { class: "legend" }, ...entries)), holder));

    const sound = lines.filter(({ run }) => isSound(runs[run]));
    const { unit, size } = scaleFor(channel.unit, Math.max(...(sound.length > 0 ? sound : lines).map(({ curve }) => largest(curve.values))));
    let plot: Plot | undefined = undefined; // the chart may call back before it is there
    const chart = new Chart(holder, {
      width: Math.max(this.root.clientWidth, 200),
      height,
      range: this.visible,
      unit: "s",
      data: uPlot.join(lines.map((line) => [line.time, scaled(line.curve.values, size)] as uPlot.AlignedData)),
      lines: lines.map(({ run }) => ({ color: runColor(run) })),
      units: [unitLabel(unit)],
      key: "time",
      gutters: this.gutters,
      clock: this.clock,
      vertical: (u) => this.vertical(u, lines),
      pointed: () => this.readOut(plot),
      zoomed: (range) => (this.range = range),
    });
    plot = { chart, lines, size, unit: unit === "1" ? "" : unit, height };
    this.plots.push(plot);
    lines.forEach(({ run }, k) => this.hidden.has(run) && chart.uplot.setSeries(k + 1, { show: false }));
  }

  private vertical(u: uPlot, lines: Line[]): [number | null, number | null] {
    const extents: Record<"sound" | "others", [number, number][]> = { sound: [], others: [] };
    lines.forEach(({ run }, k) => {
      const { show, idxs } = u.series[k + 1];
      const own = show && idxs ? extent(u.data[k + 1], idxs[0], idxs[1]) : null;
      if (own) extents[isSound(this.comparison.runs[run]) ? "sound" : "others"].push(own);
    });
    const range = overlayRange(extents.sound, extents.others);
    return range ? uPlot.rangeNum(range[0], range[1], 0.1, true) : [null, null];
  }

  /** The marker and the values in the captions go with the animation's time. */
  private follow(): void {
    for (const plot of this.plots) {
      plot.chart.place();
      this.readOut(plot);
    }
  }

  /** Values under the cursor; where there is none, those at the animation's time. */
  private readOut(plot: Plot | undefined): void {
    if (!plot) return;
    const { uplot } = plot.chart;
    const index = uplot.cursor.idx;
    const t = index == null ? this.clock.time : uplot.data[0][index];
    // With the digits that the plot can show: a failed run's own range may be absurd.
    const { min, max } = uplot.scales.y;
    const range = min == null || max == null ? 0 : max - min;
    for (const { run, time, curve, value } of plot.lines) {
      const now = this.hidden.has(run) ? null : valueAt(time, curve.values, t);
      value.textContent = now === null ? "–" : `${formatWithin(range, now / plot.size)} ${plot.unit}`.trim();
    }
  }

  private resize(): void {
    const width = Math.max(this.root.clientWidth, 200);
    for (const { chart, height } of this.plots) if (chart.uplot.width !== width) chart.uplot.setSize({ width, height });
    this.follow();
  }
}
