// One chart over time or frequency. Charts over time share their cursor with all others, and a marker stands at the
// animation's time.
import uPlot from "uplot";
import type { Clock } from "./clock";
import { element, themeColor } from "./dom";
import { axisScale, logarithmicTicks, tickLabels } from "./engineering";
import { formatNumber } from "./format";
import type { Range } from "./trace";

export interface ChartLine {
  color: string;
  /** On the axis at the right, dashed. */
  second?: boolean;
}

export interface ChartOptions {
  width: number;
  height: number;
  range: Range;
  /** Of the horizontal axis. */
  unit: string;
  /** Times or frequencies, then one list of values per line; null is a gap, undefined an instant of another curve. */
  data: uPlot.AlignedData;
  lines: ChartLine[];
  /** Of the vertical axis, and of the second, where a line is on it. */
  units: [string, string?];
  /** Of charts below each other, whose horizontal axes are to have one place. */
  gutters?: Gutters;
  /** Equal steps are equal factors. */
  logarithmic?: boolean;
  /** The same of the horizontal axis. */
  logarithmicAcross?: boolean;
  /** Marks of the vertical axis; without, those of round numbers. */
  ticks?: (low: number, high: number) => number[];
  /** Of the vertical axis, where it is not simply that of the values in sight. */
  vertical?: (chart: uPlot) => [number | null, number | null];
  /** Charts with one key share their cursor. */
  key: string;
  /** The animation's time is marked, and set by a click. */
  clock?: Clock;
  /** The cursor has moved, perhaps away. */
  pointed?: () => void;
  /** Another part is shown. */
  zoomed?: (range: Range) => void;
}

/** The widest of what stands left and right of charts below each other, px. */
export interface Gutters {
  left: number;
  right: number;
}

export function axisStyle(): uPlot.Axis {
  const grid = { stroke: themeColor("grid"), width: 1 };
  return { stroke: themeColor("muted"), grid, ticks: grid, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif", labelSize: 18 };
}

const rightPadding = 17; // px, half of the last label of the horizontal axis

/** With a margin; around a value that never changes. */
function valueRange(_: uPlot, low: number | null, high: number | null): uPlot.Range.MinMax {
  if (low === null || high === null) return [low!, high!];
  if (low < high) return uPlot.rangeNum(low, high, 0.1, true);
  const pad = Math.abs(low) > 0 ? 0.1 * Math.abs(low) : 1;
  return [low - pad, low + pad];
}

/** As wide as the longest label needs. */
export const axisWidth = (_: uPlot, labels: string[] | null) => 19 + 7.2 * Math.max(2, ...(labels ?? []).map((label) => (label ?? "").length));

/** Marks of an axis on which equal steps are equal factors. */
function factors(unit = ""): uPlot.Axis {
  return { splits: (_, __, low, high) => logarithmicTicks(low, high), filter: (_, splits) => splits, values: (_, splits) => splits.map((value) => formatNumber(value, 3) + unit) };
}

export class Chart {
  readonly uplot: uPlot;
  private marker = element("div", { class: "marker" });
  private built = false; // the hooks may be called before the chart is there

  constructor(
    holder: HTMLElement,
    private options: ChartOptions,
  ) {
    const axis = axisStyle();
    const { vertical, clock, lines, units, logarithmic, logarithmicAcross, ticks } = options;
    const { gutters = { left: 0, right: 0 } } = options;
    const sized = (side: keyof Gutters) => (u: uPlot, labels: string[] | null) => (gutters[side] = Math.max(gutters[side], axisWidth(u, labels)));
    const vertically: uPlot.Axis = { ...axis, size: sized("left") as uPlot.Axis.Size };
    const alone = !lines.some(({ second }) => second);
    if (ticks) vertically.splits = (_, __, low, high) => ticks(low, high);
    if (logarithmic && logarithmicAcross) Object.assign(vertically, factors());
    if (!logarithmic) vertically.values = (_, splits) => tickLabels(splits);
    const own: uPlot.Scale = logarithmic ? { distr: 3 } : { range: valueRange };
    const scale: uPlot.Scale = { ...own, ...(vertical ? { range: (u: uPlot) => vertical(u) as uPlot.Range.MinMax } : {}) };
    this.uplot = new uPlot(
      {
        width: options.width,
        height: options.height,
        legend: { show: false },
        // Without an axis at the right, as much room as others need for theirs and its label.
        padding: [null, alone ? () => (gutters.right > 0 ? gutters.right + axis.labelSize! : logarithmicAcross ? 1.5 * rightPadding : rightPadding) : null, null, null],
        // Points that are dense show the steps of pixels.
        ...(logarithmicAcross ? { pxAlign: 0 } : {}),
        scales: { x: { time: false, ...(logarithmicAcross ? { distr: 3 } : {}), ...options.range }, y: scale, second: own },
        cursor: {
          sync: { key: options.key },
          drag: { x: true, y: false, dist: 5 },
          points: { size: 6 },
        },
        series: [
          {},
          ...lines.map(({ color, second }) => ({ stroke: color, width: 1.5, points: { show: false }, scale: second ? "second" : "y", ...(second ? { dash: [7, 4] } : {}) })),
        ],
        axes: [
          { ...axis, size: 30, ...(logarithmicAcross ? factors(` ${options.unit}`) : { values: (u, splits) => this.across(u, splits) }) },
          { ...vertically, label: units[0] },
          ...(alone ? [] : [{ ...vertically, size: sized("right"), scale: "second", side: 1, label: units[1], grid: { show: false } } as uPlot.Axis]),
        ],
        hooks: {
          setCursor: [() => this.built && options.pointed?.()],
          setScale: [
            (u, key) => {
              if (key !== "x") return;
              options.zoomed?.({ min: u.scales.x.min!, max: u.scales.x.max! });
              if (this.built) this.place();
            },
          ],
        },
      },
      options.data,
      holder,
    );
    this.built = true;
    if (!clock) return;
    const { uplot } = this;
    uplot.over.append(this.marker);
    // A click, not the end of a drag, sets the animation's time.
    let pressed = 0;
    uplot.over.addEventListener("mousedown", (event) => (pressed = event.clientX));
    uplot.over.addEventListener("click", (event) => {
      const left = event.clientX - uplot.over.getBoundingClientRect().left;
      if (Math.abs(event.clientX - pressed) < 5) clock.stopAt(uplot.posToVal(left, "x"));
    });
  }

  /** The gutters may have grown since it was drawn. */
  align(): void {
    this.uplot.redraw(false, true);
    this.place();
  }

  private across({ scales }: uPlot, splits: number[]): string[] {
    const { min, max } = scales.x;
    const { unit, size } = axisScale(this.options.unit, Math.max(Math.abs(min ?? 0), Math.abs(max ?? 0)));
    return tickLabels(splits.map((value) => value / size)).map((label) => `${label} ${unit}`);
  }

  /** The marker goes to the animation's time. */
  place(): void {
    const { clock } = this.options;
    if (!clock) return;
    const { min, max } = this.uplot.scales.x;
    const { time } = clock;
    this.marker.hidden = min == null || max == null || time < min || time > max;
    if (!this.marker.hidden) this.marker.style.transform = `translateX(${this.uplot.valToPos(time, "x")}px)`;
  }
}
