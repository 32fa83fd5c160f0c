// One chart over time; it shares its cursor with all others, and a marker stands at the animation's time.
import uPlot from "uplot";
import type { Clock } from "./clock";
import { element, themeColor } from "./dom";
import { formatNumber } from "./format";

export interface Range {
  min: number;
  max: number;
}

export interface ChartOptions {
  width: number;
  height: number;
  time: Range;
  /** Times, then one list of values per colour; null is a gap, undefined an instant of another curve. */
  data: uPlot.AlignedData;
  colors: string[];
  /** Of the vertical axis, where it is not simply that of the values in sight. */
  vertical?: (chart: uPlot) => [number | null, number | null];
  /** The cursor has moved, perhaps away. */
  pointed: () => void;
  /** Another part of the time is shown. */
  zoomed: (range: Range) => void;
}

export class TimeChart {
  readonly uplot: uPlot;
  private marker = element("div", { class: "marker" });
  private built = false; // the hooks may be called before the chart is there

  constructor(
    holder: HTMLElement,
    private clock: Clock,
    options: ChartOptions,
  ) {
    const grid = { stroke: themeColor("grid"), width: 1 };
    const axis: uPlot.Axis = { stroke: themeColor("muted"), grid, ticks: grid, font: "12px system-ui, sans-serif" };
    const { vertical } = options;
    this.uplot = new uPlot(
      {
        width: options.width,
        height: options.height,
        legend: { show: false },
        scales: { x: { time: false, ...options.time }, ...(vertical ? { y: { range: (u) => vertical(u) as uPlot.Range.MinMax } } : {}) },
        cursor: {
          sync: { key: "time" },
          drag: { x: true, y: false, dist: 5 },
          points: { size: 6 },
        },
        series: [{}, ...options.colors.map((stroke) => ({ stroke, width: 1.5, points: { show: false } }))],
        axes: [
          { ...axis, size: 30, values: (_, splits) => splits.map((split) => `${formatNumber(split)} s`) },
          { ...axis, size: 64, values: (_, splits) => splits.map((split) => formatNumber(split)) },
        ],
        hooks: {
          setCursor: [() => this.built && options.pointed()],
          setScale: [
            (u, key) => {
              if (key !== "x") return;
              options.zoomed({ min: u.scales.x.min!, max: u.scales.x.max! });
              if (this.built) this.place();
            },
          ],
        },
      },
      options.data,
      holder,
    );
    this.built = true;
    const { uplot } = this;
    uplot.over.append(this.marker);
    // A click, not the end of a drag, sets the animation's time.
    let pressed = 0;
    uplot.over.addEventListener("mousedown", (event) => (pressed = event.clientX));
    uplot.over.addEventListener("click", (event) => {
      const left = event.clientX - uplot.over.getBoundingClientRect().left;
      if (Math.abs(event.clientX - pressed) < 5) this.clock.set(uplot.posToVal(left, "x"));
    });
  }

  /** The marker goes to the animation's time. */
  place(): void {
    const { min, max } = this.uplot.scales.x;
    const { time } = this.clock;
    this.marker.hidden = min == null || max == null || time < min || time > max;
    if (!this.marker.hidden) this.marker.style.transform = `translateX(${this.uplot.valToPos(time, "x")}px)`;
  }
}
