// The card with the chosen channels over the last seconds.
import type uPlot from "uplot";
import { ChannelList } from "./channelList";
import { Chart } from "./chart";
import { lineColors } from "./color";
import type { ChannelName } from "./data";
import { element, onThemeChange } from "./dom";
import { onSecondAxis, scaleFor, type Scale } from "./engineering";
import { figure } from "./figure";
import { formatWithin } from "./format";
import { unitLabel } from "./groups";
import type { StripRecord } from "./liveStrip";
import { choice } from "./slider";
import { byUnit, largest, type Trace } from "./trace";

interface Plot {
  chart: Chart;
  values: HTMLElement[];
  channels: number[];
  unit: string;
  second: boolean[];
  scales: Scale[]; // per channel
}

const height = 150;
const lengths = [5, 10, 20, 60];

export class Strips {
  readonly root: HTMLElement;
  readonly selected: Set<number>;
  private holder = element("div", { class: "plots" });
  private list: ChannelList;
  private plots: Plot[] = [];
  private gutters = { left: 0, right: 0 };
  private frozen = false;
  private drawn = -Infinity; // when, s of this machine
  private measured = -Infinity; // when the scales were last looked after
  private every: number; // s between two drawings at least

  constructor(
    private channels: ChannelName[],
    shown: number[],
    private record: StripRecord,
    /** Other channels are chosen. */
    private chosen: () => void,
  ) {
    this.selected = new Set(shown);
    this.every = matchMedia("(prefers-reduced-motion: reduce)").matches ? 0.5 : 0.04;
    const changed = () => {
      this.list.refresh();
      this.chosen();
      this.build();
    };
    this.list = new ChannelList(channels, this.selected, changed);
    const freeze = element("button", { "aria-pressed": "false", title: "Freeze the charts; drag across to zoom" }, "Freeze");
    freeze.addEventListener("click", () => {
      this.frozen = !this.frozen;
      freeze.setAttribute("aria-pressed", String(this.frozen));
    });
    const span = choice("Last", lengths.map((length) => ({ value: String(length), text: `${length} s` })), String(record.length), (length) => (this.record.length = Number(length)));
    this.root = element(
      "section",
      { class: "card strips" },
      element("div", { class: "row heading" }, element("h2", {}, "Channels"), span, freeze),
      this.holder,
      element("details", { class: "all" }, element("summary", {}, `Select from ${channels.length} channels`), this.list.root),
    );
    onThemeChange(() => this.build());
    new ResizeObserver(() => this.resize()).observe(this.holder);
    this.build();
  }

  /** `now`: s of this machine; `time`: of the simulation, at the right end. */
  draw(now: number, time: number): void {
    if (this.frozen || now - this.drawn < this.every) return;
    this.drawn = now;
    if (now - this.measured > 1) {
      this.measured = now;
      if (this.plots.some((plot) => this.outgrown(plot))) this.build();
    }
    for (const plot of this.plots) {
      const { uplot } = plot.chart;
      const values = plot.channels.map((channel) => this.record.of(channel));
      const data = [this.record.time, ...values.map((one, k) => (plot.scales[k].size === 1 ? one : one.map((value) => (value === null ? null : value / plot.scales[k].size))))];
      uplot.batch(() => {
        uplot.setData(data as uPlot.AlignedData, false);
        uplot.setScale("x", { min: time - this.record.length, max: Math.max(time, time - this.record.length + 1e-6) });
      });
      const shown = [false, true].map((right) => Math.max(0, ...values.filter((_, k) => plot.second[k] === right).map(largest)));
      values.forEach((one, k) => {
        const value = one[one.length - 1] ?? null;
        const { size, unit } = plot.scales[k];
        plot.values[k].textContent = value === null ? "–" : `${formatWithin((10 * shown[Number(plot.second[k])]) / size, value / size)} ${unit === "1" ? "" : unit}`.trim();
      });
    }
  }

  /** By the values that are there now. */
  private measure(unit: string, channels: number[]): Pick<Plot, "second" | "scales"> {
    const ranges = channels.map((channel) => {
      const values = this.record.of(channel).filter((value): value is number => value !== null);
      return values.reduce((most, value) => Math.max(most, value), -Infinity) - values.reduce((least, value) => Math.min(least, value), Infinity);
    });
    // What changes by round-off alone needs no axis of its own.
    const least = 1e-6 * Math.max(0, ...channels.map((channel) => largest(this.record.of(channel))));
    const second = onSecondAxis(ranges.map((range) => (range > least ? range : 0)));
    const scaleOf = (right: boolean) => scaleFor(unit, Math.max(0, ...channels.filter((_, k) => second[k] === right).map((channel) => largest(this.record.of(channel)))));
    const [left, right] = [scaleOf(false), scaleOf(true)];
    return { second, scales: channels.map((_, k) => (second[k] ? right : left)) };
  }

  private outgrown({ unit, channels, scales, second }: Plot): boolean {
    const now = this.measure(unit, channels);
    return channels.some((_, k) => now.scales[k].size > scales[k].size || now.scales[k].size < 1e-3 * scales[k].size || (second[k] !== now.second[k] && !second.includes(true)));
  }

  private build(): void {
    for (const { chart } of this.plots) chart.uplot.destroy();
    this.holder.replaceChildren();
    const traces = [...this.selected].sort((a, b) => a - b).map((channel, k): Trace => {
      const { name, unit, meaning } = this.channels[channel];
      return { name, unit, meaning, channel, run: 0, label: name, color: lineColors[k % lineColors.length], time: [], values: [], range: 0 };
    });
    if (traces.length === 0) this.holder.append(element("p", { class: "hint" }, "No channel is selected. Tick some in the list below."));
    this.gutters = { left: 0, right: 0 };
    this.plots = [...byUnit(traces)].map(([unit, of]) => this.plot(unit, of));
    this.drawn = -Infinity;
  }

  private plot(unit: string, traces: Trace[]): Plot {
    const channels = traces.map(({ channel }) => channel);
    const { second, scales } = this.measure(unit, channels);
    const unitOf = (right: boolean) => unitLabel(scales[second.indexOf(right)]?.unit ?? unit);
    const title = second.includes(true) && unitOf(true) !== unitOf(false) ? `${unitOf(false)}, ${unitOf(true)}` : unitOf(false);
    const remove = (channel: number) => {
      this.selected.delete(channel);
      this.list.refresh();
      this.chosen();
      this.build();
    };
    const made = figure(title, "The last seconds", traces, remove, second);
    this.holder.append(made.root);
    const time = this.record.time[this.record.time.length - 1] ?? 0;
    const chart = new Chart(made.holder, {
      width: Math.max(this.holder.clientWidth, 200),
      height,
      range: { min: time - this.record.length, max: time },
      unit: "s",
      data: [[], ...traces.map(() => [])] as unknown as uPlot.AlignedData,
      lines: traces.map(({ color }, k) => ({ color, second: second[k] })),
      units: [unitOf(false), unitOf(true)],
      key: "live",
      gutters: this.gutters,
    });
    return { chart, values: made.values, channels, unit, second, scales };
  }

  private resize(): void {
    const width = Math.max(this.holder.clientWidth, 200);
    for (const { chart } of this.plots) if (chart.uplot.width !== width) chart.uplot.setSize({ width, height });
  }
}
