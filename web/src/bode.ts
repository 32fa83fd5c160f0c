// The page of Bode plots: responses of a linear model from an input that is chosen to outputs that are ticked.
import type uPlot from "uplot";
import { decibels, firstInput, firstOutputs, magnitudes, phases, phaseTicks, ratioUnit, responseOf, type Bode } from "./bodeData";
import { ChannelList } from "./channelList";
import { Chart } from "./chart";
import { lineColors } from "./color";
import { field } from "./csv";
import { element, onThemeChange } from "./dom";
import { fileName, save, saveCanvas } from "./download";
import { figure } from "./figure";
import { formatNumber } from "./format";
import { warningList } from "./panels";
import { pictureOf } from "./plotPicture";
import { choice } from "./slider";
import type { Range, Trace } from "./trace";

type Scale = "decibels" | "logarithmic" | "linear";

const scales: { value: Scale; text: string }[] = [
  { value: "decibels", text: "dB" },
  { value: "logarithmic", text: "logarithmic" },
  { value: "linear", text: "linear" },
];

const height = 250;

/** One of the outputs that are shown. */
interface Curve {
  trace: Trace;
  size: number[];
  phase: (number | null)[];
}

interface Plot {
  chart: Chart;
  values: HTMLElement[];
}

class BodePlots {
  readonly root = element("div", { class: "plots" });
  private plots: Plot[] = [];
  private curves: Curve[] = [];
  private gutters = { left: 0, right: 0 };
  private whole: Range;
  private range: Range;
  private where = element("p", { class: "hint", "aria-live": "polite" });

  constructor(
    private bode: Bode,
    private remove: (output: number) => void,
  ) {
    const { frequencies } = bode;
    this.whole = { min: frequencies[0], max: frequencies[frequencies.length - 1] };
    this.range = this.whole;
    new ResizeObserver(() => this.resize()).observe(this.root);
  }

  show(input: number, outputs: number[], scale: Scale): void {
    for (const { chart } of this.plots) chart.uplot.destroy();
    this.plots = [];
    this.gutters = { left: 0, right: 0 };
    this.root.replaceChildren(this.where);
    this.curves = outputs.map((output, k) => this.curve(input, output, lineColors[k % lineColors.length]));
    if (this.curves.length === 0) {
      this.where.textContent = "No output is selected. Tick some in the list.";
      return;
    }
    const units = new Set(this.curves.map(({ trace }) => trace.unit));
    const unit = units.size === 1 ? [...units][0] : "SI units";
    if (scale === "decibels") this.add("Magnitude", `dB (${unit})`, this.curves.map(({ size }) => decibels(size)));
    else if (scale === "linear") this.add("Magnitude", unit, this.curves.map(({ size }) => size));
    else this.add("Magnitude", unit, this.curves.map(({ size }) => size.map((value) => (value > 0 ? value : null))), { logarithmic: true });
    this.add("Phase", "°", this.curves.map(({ phase }) => phase), { ticks: phaseTicks });
    for (const { chart } of this.plots) chart.align();
    this.readOut();
  }

  resetZoom(): void {
    for (const { chart } of this.plots) chart.uplot.setScale("x", this.whole);
  }

  /** Magnitude and phase of all curves. */
  csv(): string {
    const heads = this.curves.flatMap(({ trace: { label, unit } }) => [`${label} magnitude [${unit}]`, `${label} phase [deg]`]);
    const rows = this.bode.frequencies.map((frequency, k) => [frequency, ...this.curves.flatMap(({ size, phase }) => [size[k], phase[k] ?? ""])]);
    return [["frequency [Hz]", ...heads].map(field), ...rows].map((row) => row.join(",")).join("\r\n") + "\r\n";
  }

  private curve(input: number, output: number, color: string): Curve {
    const response = responseOf(this.bode, input, output);
    const { name, unit } = this.bode.outputs[output];
    const size = magnitudes(response);
    const trace = { name, label: name, meaning: "", unit: ratioUnit(unit, this.bode.inputs[input].unit), channel: output, run: 0, color, time: this.bode.frequencies, values: size, range: 0 };
    return { trace, size, phase: phases(response) };
  }

  private add(what: string, unit: string, columns: (number | null)[][], more: { logarithmic?: boolean; ticks?: (low: number, high: number) => number[] } = {}): void {
    const traces = this.curves.map(({ trace }) => trace);
    const { root, holder, values } = figure(`${what}, ${unit}`, what, traces, this.remove);
    this.root.append(root);
    const chart = new Chart(holder, {
      width: Math.max(this.root.clientWidth, 200),
      height,
      range: this.range,
      unit: "Hz",
      data: [this.bode.frequencies, ...columns] as uPlot.AlignedData,
      lines: traces.map(({ color }) => ({ color })),
      units: [unit],
      gutters: this.gutters,
      logarithmicAcross: true,
      key: "frequency",
      pointed: () => this.readOut(chart),
      zoomed: (range) => this.zoom(range),
      ...more,
    });
    this.plots.push({ chart, values });
  }

  /** Both charts show the same frequencies. */
  private zoom(range: Range): void {
    this.range = range;
    for (const { chart } of this.plots) {
      const { min, max } = chart.uplot.scales.x;
      if (min !== range.min || max !== range.max) chart.uplot.setScale("x", range);
    }
  }

  /** Values under the cursor; where there is none, the highest in sight. */
  private readOut(pointed?: Chart): void {
    if (this.plots.length < 2) return;
    const { frequencies } = this.bode;
    const at = (pointed ?? this.plots[0].chart).uplot.cursor.idx ?? null;
    this.where.textContent = at === null ? "Highest magnitudes in sight. Point at a plot to read values." : `At ${formatNumber(frequencies[at], 5)} Hz`;
    const { min, max } = this.range;
    const highest = (size: number[]) => size.reduce((best, value, k) => (frequencies[k] >= min && frequencies[k] <= max && !(value <= size[best]) ? k : best), frequencies.findIndex((value) => value >= min));
    this.curves.forEach(({ trace: { unit }, size, phase }, k) => {
      const place = at ?? highest(size);
      const decibel = size[place] > 0 ? ` (${formatNumber(20 * Math.log10(size[place]), 4)} dB)` : "";
      const where = at === null ? ` at ${formatNumber(frequencies[place], 4)} Hz` : "";
      const angle = phase[place];
      this.plots[0].values[k].textContent = `${formatNumber(size[place], 4)}${unit === "no unit" ? "" : ` ${unit}`}${decibel}${where}`;
      this.plots[1].values[k].textContent = angle === null ? "–" : `${formatNumber(Number(angle.toFixed(2)))}°${where}`;
    });
  }

  private resize(): void {
    const width = Math.max(this.root.clientWidth, 200);
    for (const { chart } of this.plots) if (chart.uplot.width !== width) chart.uplot.setSize({ width, height });
  }
}

function button(text: string, title: string, pressed: () => void): HTMLElement {
  const made = element("button", { title }, text);
  made.addEventListener("click", pressed);
  return made;
}

const count = (number: number, one: string) => `${number} ${one}${number === 1 ? "" : "s"}`;

/** Fills the page. */
export function buildBode(page: HTMLElement, bode: Bode): void {
  let input = firstInput(bode);
  const selected = new Set(firstOutputs(bode, input));
  let scale: Scale = "decibels";
  const show = () => plots.show(input, [...selected].sort((a, b) => a - b), scale);
  const changed = () => {
    show();
    list.refresh();
  };
  const plots = new BodePlots(bode, (output) => {
    selected.delete(output);
    changed();
  });
  const list = new ChannelList(bode.outputs.map((output) => ({ ...output, meaning: "" })), selected, changed);
  const inputs = bode.inputs.map(({ name, unit }, k) => ({ value: String(k), text: unit === "" || unit === "1" ? name : `${name}, ${unit}` }));
  const settings = element(
    "div",
    { class: "settings" },
    choice("Input", inputs, String(input), (value) => ((input = Number(value)), show())),
    choice("Magnitude", scales, "decibels", (value) => ((scale = value), show())),
  );
  const name = () => `bode-${bode.inputs[input].name.replace(/[^\p{L}\p{N}]+/gu, "-")}`;
  const heading = element(
    "div",
    { class: "row heading" },
    element("h2", {}, "Responses"),
    button("Reset zoom", "Show all frequencies (or double-click a plot)", () => plots.resetZoom()),
    button("Save CSV", "Magnitude and phase of the selected outputs", () => save(fileName(name(), "csv"), new Blob([plots.csv()], { type: "text/csv" }))),
    button("Save plots", "Save the charts as PNG", () => {
      const canvas = pictureOf(plots.root);
      if (canvas) saveCanvas(canvas, name());
    }),
  );
  const hint = "Drag across a plot to zoom, double-click to show all. Phases are continued over ±180°.";
  const choices = element("section", { class: "card choices" }, element("h2", {}, "Shown"), settings, element("h3", {}, "Outputs"), list.root);
  const charts = element("section", { class: "card" }, heading, element("p", { class: "hint" }, hint), plots.root);
  const notes = element("section", { class: "card summary" }, element("h2", {}, "Notes"), element("ul", {}, ...bode.notes.map((text) => element("li", {}, text))));
  page.append(
    element(
      "header",
      {},
      element("h1", {}, `${bode.title || "Untitled model"}: frequency responses`),
      element("p", {}, `Point: ${bode.point} · ${count(bode.inputs.length, "input")}, ${count(bode.outputs.length, "output")}`),
      ...warningList(bode.warnings),
    ),
    element("main", { class: "bode" }, choices, charts, ...(bode.notes.length > 0 ? [notes] : [])),
  );
  onThemeChange(show);
  show();
}
