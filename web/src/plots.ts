// Stacked plots, one per unit, with one time axis: cursors and zoom go together.
import type uPlot from "uplot";
import { TimeChart, type Range } from "./chart";
import type { Clock } from "./clock";
import { lineColors } from "./color";
import type { Report } from "./data";
import { element, onThemeChange } from "./dom";
import { formatWithin } from "./format";
import { unitLabel } from "./groups";
import { nearest } from "./interpolate";

interface Plot {
  chart: TimeChart;
  values: HTMLElement[];
  channels: number[];
}

const height = 190;

export class Plots {
  readonly root = element("div", { class: "plots" });
  private plots: Plot[] = [];
  private selection: number[] = [];
  private range: Range | null = null; // of the time axis, null when all is shown

  constructor(
    private report: Report,
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
    if (this.report.time.length === 0 || selection.length === 0) {
      const why = selection.length > 0 ? "The results hold no instants." : "No channel is chosen: tick some in the list.";
      this.root.append(element("p", { class: "hint" }, why));
      return;
    }
    const units = new Map<string, number[]>();
    for (const index of selection) {
      const unit = this.report.channels[index].unit;
      units.set(unit, [...(units.get(unit) ?? []), index]);
    }
    this.plots = [...units].map(([unit, channels]) => this.plot(unit, channels));
    this.follow();
  }

  resetZoom(): void {
    for (const { chart } of this.plots) chart.uplot.setScale("x", this.whole());
  }

  private whole(): Range {
    const { time } = this.report;
    return { min: time[0], max: time[time.length - 1] };
  }

  private plot(unit: string, channels: number[]): Plot {
    const values: HTMLElement[] = [];
    const legend = element("div", { class: "legend" });
    channels.forEach((index, k) => {
      const channel = this.report.channels[index];
      const value = element("span", { class: "value" });
      values.push(value);
      const swatch = element("span", { class: "swatch" });
      swatch.style.background = lineColors[k % lineColors.length];
      const close = element("button", { class: "close", "aria-label": `Remove ${channel.name}`, title: "Remove" }, "×");
      close.addEventListener("click", () => this.remove(index));
      legend.append(element("span", { class: "entry", title: channel.meaning }, swatch, channel.name, value, close));
    });
    const holder = element("div", {
      role: "img",
      "aria-label": `Plot over time of ${channels.map((index) => this.report.channels[index].name).join(", ")}`,
    });
    const box = element("figure", {}, element("figcaption", {}, element("b", {}, unitLabel(unit)), legend), holder);
    this.root.append(box);

    let plot: Plot | undefined = undefined; // the chart may call back before it is there
    const chart = new TimeChart(holder, this.clock, {
      width: Math.max(this.root.clientWidth, 200),
      height,
      time: this.range ?? this.whole(),
      data: [this.report.time, ...channels.map((index) => this.report.channels[index].values)] as uPlot.AlignedData,
      colors: channels.map((_, k) => lineColors[k % lineColors.length]),
      pointed: () => this.readOut(plot),
      zoomed: (range) => (this.range = range),
    });
    plot = { chart, values, channels };
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
    if (!plot || this.report.time.length === 0) return;
    const index = plot.chart.uplot.cursor.idx ?? nearest(this.report.time, this.clock.time);
    plot.channels.forEach((channel, k) => {
      const { values, range } = this.report.channels[channel];
      const value = values[index];
      plot.values[k].textContent = value == null ? "–" : formatWithin(range, value);
    });
  }

  private resize(): void {
    const width = Math.max(this.root.clientWidth, 200);
    for (const { chart } of this.plots) if (chart.uplot.width !== width) chart.uplot.setSize({ width, height });
    this.follow();
  }
}
