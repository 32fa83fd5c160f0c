// Spectra of the chosen curves over the part of the time that is shown, one chart per unit.
import type uPlot from "uplot";
import uPlotJoin from "uplot";
import { Chart } from "./chart";
import { element, onThemeChange } from "./dom";
import { scaleFor } from "./engineering";
import { figure } from "./figure";
import { formatNumber } from "./format";
import { unitLabel } from "./groups";
import type { View } from "./plots";
import { checkbox, choice } from "./slider";
import { spectrum, telling, type Spectrum, type Window } from "./spectrum";
import { byUnit, type Curves, type Range, type Trace } from "./trace";

const height = 210;

export class SpectrumPlots implements View {
  readonly root = element("div", { class: "plots" });
  private holder = element("div");
  private charts: Chart[] = [];
  private selection: number[] = [];
  private window: Window = "hann";
  private logarithmic = false;

  constructor(
    private curves: Curves,
    private visible: () => Range,
    private remove: (channel: number) => void,
  ) {
    const again = () => this.selection.length > 0 && this.show(this.selection);
    const windows = [
      { value: "hann" as const, text: "Hann: separates peaks" },
      { value: "flat top" as const, text: "flat top: exact heights" },
      { value: "none" as const, text: "none" },
    ];
    const settings = element(
      "div",
      { class: "settings" },
      choice("Window", windows, "hann", (window) => ((this.window = window), again())),
      checkbox("Logarithmic", false, (on) => ((this.logarithmic = on), again())),
    );
    this.root.append(settings, element("p", { class: "hint" }, "Amplitudes over the interval that the plots show, mean removed. Drag to zoom, double-click to show all."), this.holder);
    onThemeChange(again);
    new ResizeObserver(() => this.resize()).observe(this.root);
  }

  show(selection: number[]): void {
    this.selection = selection;
    for (const chart of this.charts) chart.uplot.destroy();
    this.charts = [];
    this.holder.replaceChildren();
    const { min, max } = this.visible();
    const made = this.curves.traces(selection).map((trace): [Trace, Spectrum] => [trace, spectrum(trace.time, trace.values, this.window, min, max)]);
    const sound = made.filter(([, { frequency }]) => frequency.length > 0);
    if (sound.length < made.length || made.length === 0)
      this.holder.append(element("p", { class: "hint" }, made.length === 0 ? "No channel is selected. Tick some in the list." : "A spectrum needs at least eight instants without a gap."));
    const spectra = new Map(sound);
    // On a logarithmic axis everything is worth seeing.
    const end = Math.max(...sound.map(([, one]) => (this.logarithmic ? one.frequency[one.frequency.length - 1] : telling(one))));
    for (const [unit, traces] of byUnit([...spectra.keys()])) this.plot(unit, traces, spectra, end);
  }

  private plot(unit: string, traces: Trace[], spectra: Map<Trace, Spectrum>, end: number): void {
    const all = traces.map((trace) => spectra.get(trace)!);
    const { unit: shown, size } = scaleFor(unit, Math.max(...all.flatMap(({ amplitude }) => amplitude.reduce((a, b) => Math.max(a, b), 0))));
    const { root, holder, values } = figure(unitLabel(shown), "Spectrum", traces, this.remove);
    // The highest line, where one looks first.
    all.forEach(({ frequency, amplitude }, k) => {
      const peak = amplitude.reduce((best, value, m) => (value > amplitude[best] ? m : best), 0);
      values[k].textContent = `peak ${formatNumber(amplitude[peak] / size, 3)}${shown === "1" ? "" : ` ${shown}`} at ${formatNumber(frequency[peak], 4)} Hz`;
    });
    this.holder.append(root);
    const columns = all.map(({ amplitude }) => amplitude.map((value) => (this.logarithmic && !(value > 0) ? null : value / size)));
    const together = all.every(({ frequency }) => frequency.length === all[0].frequency.length && frequency[1] === all[0].frequency[1]);
    this.charts.push(
      new Chart(holder, {
        width: Math.max(this.root.clientWidth, 200),
        height,
        range: { min: 0, max: end },
        unit: "Hz",
        data: together ? ([all[0].frequency, ...columns] as uPlot.AlignedData) : uPlotJoin.join(all.map(({ frequency }, k) => [frequency, columns[k]] as uPlot.AlignedData)),
        lines: traces.map(({ color }) => ({ color })),
        units: [unitLabel(shown)],
        logarithmic: this.logarithmic,
        key: "frequency",
      }),
    );
  }

  private resize(): void {
    const width = Math.max(this.root.clientWidth, 200);
    for (const chart of this.charts) if (chart.uplot.width !== width) chart.uplot.setSize({ width, height });
  }
}
