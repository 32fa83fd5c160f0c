import "uplot/dist/uPlot.min.css";
import "./style.css";
import { bodeFormat, decodeBode, type PackedBode } from "./bodeData";
import { buildBode } from "./bode";
import { channelCard } from "./channelViews";
import { Clock } from "./clock";
import { buildComparison, comparisonTitle } from "./comparison";
import { comparisonFormat, decodeComparison, type PackedComparison } from "./comparisonData";
import { lineColors } from "./color";
import { decodeReport, type PackedReport, type Report } from "./data";
import { element } from "./dom";
import { formulaChannel } from "./formulas";
import { firstSelection } from "./groups";
import { buildMechanismModes } from "./mechanismModes";
import { decodeMechanismModes, mechanismModesFormat, type PackedMechanismModes } from "./mechanismModesData";
import { buildModes } from "./modes";
import { decodeModes, modesFormat, type PackedModes } from "./modesData";
import { header, model, summary } from "./panels";
import { Player } from "./player";
import { Plots } from "./plots";
import type { Trace } from "./trace";

/** Fills the page; returns the clock of its animation. */
function buildReport(page: HTMLElement, report: Report): Clock {
  const { time } = report.animation;
  const clock = new Clock(time[0] ?? 0, time[time.length - 1] ?? 0, time.length);
  const traces = (selection: number[]): Trace[] =>
    selection.map((channel, k) => ({ ...report.channels[channel], channel, run: 0, label: report.channels[channel].name, color: lineColors[k % lineColors.length], time: report.time }));
  const curves = { channels: report.channels, traces };
  const whole = { min: report.time[0] ?? 0, max: report.time[report.time.length - 1] ?? 0 };
  const source = { time: report.time, channel: (name: string) => report.channels.find((channel) => channel.name === name) ?? null };
  const charts = channelCard({
    curves,
    clock,
    start: report.shown.length > 0 ? report.shown : firstSelection(report.channels),
    thinned: report.time.length < report.instants,
    overTime: (remove) => new Plots(curves, whole, clock, remove),
    addFormula: (text) => report.channels.push(formulaChannel(text, source)) - 1,
  });
  page.append(
    header(report),
    element("main", {}, element("div", { class: "column" }, new Player(report, clock).root, summary(report), model(report)), charts),
  );
  return clock;
}

function build(page: HTMLElement): void {
  performance.mark("mimbre: read");
  const packed = JSON.parse(document.getElementById("mimbre-data")!.textContent!) as PackedReport | PackedComparison | PackedModes | PackedMechanismModes | PackedBode;
  performance.mark("mimbre: parsed");
  if (packed.format === mechanismModesFormat) {
    const modes = decodeMechanismModes(packed as PackedMechanismModes);
    document.title = `${modes.title || "Untitled model"} – mimbre modes`;
    return buildMechanismModes(page, modes);
  }
  if (packed.format === bodeFormat) {
    const bode = decodeBode(packed as PackedBode);
    document.title = `${bode.title || "Untitled model"} – mimbre Bode plots`;
    return buildBode(page, bode);
  }
  let clock: Clock;
  if (packed.format === comparisonFormat) {
    const comparison = decodeComparison(packed as PackedComparison);
    document.title = `${comparisonTitle(comparison)} – mimbre report`;
    clock = buildComparison(page, comparison);
  } else if (packed.format === modesFormat) {
    const modes = decodeModes(packed as PackedModes);
    document.title = `${modes.name || "Reduced body"} – mimbre modes`;
    clock = buildModes(page, modes);
  } else {
    const report = decodeReport(packed as PackedReport);
    performance.mark("mimbre: decoded");
    document.title = `${report.title || "Untitled model"} – mimbre report`;
    clock = buildReport(page, report);
  }
  // report.html#t=4.3 opens at that time: a link can point at what is worth seeing.
  performance.mark("mimbre: built");
  const start = Number(new URLSearchParams(location.hash.slice(1)).get("t") ?? NaN);
  if (Number.isFinite(start)) clock.stopAt(start);
}

const page = document.getElementById("page")!;
try {
  build(page);
} catch (error) {
  console.error(error);
  page.append(element("p", { class: "warning", role: "alert" }, `This report cannot be shown: ${error instanceof Error ? error.message : error}`));
}
