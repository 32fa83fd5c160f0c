// Stacked plots, one per unit, with one time axis: cursors and zoom go together.
import uPlot from "uplot";
import type { Clock } from "./clock";
import { lineColors } from "./color";
import type { Report } from "./data";
import { element, onThemeChange, themeColor } from "./dom";
import { formatNumber, formatWithin } from "./format";
import { unitLabel } from "./groups";
import { nearest } from "./interpolate";

interface Plot {
  chart: uPlot;
  marker: HTMLElement;
  values: HTMLElement[];
  channels: number[];
}

const height = 190;

export class Plots {
  readonly root = element("div", { class: "plots" });
  private plots: Plot[] = [];
  private selection: number[] = [];
  private range: { min: number; max: number } | null = null; // of the time axis, null when all is shown

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
    for (const { chart } of this.plots) chart.destroy();
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
    for (const { chart } of this.plots) chart.setScale("x", this.whole());
  }

  private whole(): { min: number; max: number } {
    const { time } = this.report;
    return { min: time[0], max: time[time.length - 1] };
  }

  private plot(unit: string, channels: number[]): Plot {
    const text = themeColor("muted");
    const grid = { stroke: themeColor("grid"), width: 1 };
    const axis: uPlot.Axis = { stroke: text, grid, ticks: grid, font: "12px system-ui, sans-serif" };
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

    let plot: Plot | undefined = undefined; // the hooks may be called before it is there
    const chart = new uPlot(
      {
        width: Math.max(this.root.clientWidth, 200),
        height,
        legend: { show: false },
        scales: { x: { time: false, ...(this.range ?? this.whole()) } },
        cursor: {
          sync: { key: "time" },
          drag: { x: true, y: false, dist: 5 },
          points: { size: 6 },
        },
        series: [
          {},
          ...channels.map((_, k) => ({
            stroke: lineColors[k % lineColors.length],
            width: 1.5,
            points: { show: false },
          })),
        ],
        axes: [
          { ...axis, size: 30, values: (_, splits) => splits.map((split) => `${formatNumber(split)} s`) },
          { ...axis, size: 64, values: (_, splits) => splits.map((split) => formatNumber(split)) },
        ],
        hooks: {
          setCursor: [() => this.readOut(plot)],
          setScale: [
            (u, key) => {
              if (key === "x") {
                this.range = { min: u.scales.x.min!, max: u.scales.x.max! };
                this.place(plot);
              }
            },
          ],
        },
      },
      [this.report.time, ...channels.map((index) => this.report.channels[index].values)] as uPlot.AlignedData,
      holder,
    );
    const marker = element("div", { class: "marker" });
    chart.over.append(marker);
    plot = { chart, marker, values, channels };
    // A click, not the end of a drag, sets the animation's time.
    let pressed = 0;
    chart.over.addEventListener("mousedown", (event) => (pressed = event.clientX));
    chart.over.addEventListener("click", (event) => {
      const left = event.clientX - chart.over.getBoundingClientRect().left;
      if (Math.abs(event.clientX - pressed) < 5) this.clock.set(chart.posToVal(left, "x"));
    });
    return plot;
  }

  /** The marker and the values in the legends go with the animation's time. */
  private follow(): void {
    for (const plot of this.plots) {
      this.place(plot);
      this.readOut(plot);
    }
  }

  private place(plot: Plot | undefined): void {
    if (!plot) return;
    const { min, max } = plot.chart.scales.x;
    const { time } = this.clock;
    plot.marker.hidden = min == null || max == null || time < min || time > max;
    if (!plot.marker.hidden) plot.marker.style.transform = `translateX(${plot.chart.valToPos(time, "x")}px)`;
  }

  /** Values under the cursor; where there is none, those at the animation's time. */
  private readOut(plot: Plot | undefined): void {
    if (!plot || this.report.time.length === 0) return;
    const index = plot.chart.cursor.idx ?? nearest(this.report.time, this.clock.time);
    plot.channels.forEach((channel, k) => {
      const { values, range } = this.report.channels[channel];
      const value = values[index];
      plot.values[k].textContent = value == null ? "–" : formatWithin(range, value);
    });
  }

  private resize(): void {
    const width = Math.max(this.root.clientWidth, 200);
    for (const { chart } of this.plots) if (chart.width !== width) chart.setSize({ width, height });
    this.follow();
  }
}
