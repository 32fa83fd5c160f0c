import "uplot/dist/uPlot.min.css";
import "./style.css";
import { ChannelList } from "./channelList";
import { Clock } from "./clock";
import { buildComparison, comparisonTitle } from "./comparison";
import { comparisonFormat, decodeComparison, type PackedComparison } from "./comparisonData";
import { decodeReport, type PackedReport, type Report } from "./data";
import { element } from "./dom";
import { firstSelection } from "./groups";
import { buildModes } from "./modes";
import { decodeModes, modesFormat, type PackedModes } from "./modesData";
import { header, model, summary } from "./panels";
import { Player } from "./player";
import { Plots } from "./plots";

/** Fills the page; returns the clock of its animation. */
function buildReport(page: HTMLElement, report: Report): Clock {
  const { time } = report.animation;
  const clock = new Clock(time[0] ?? 0, time[time.length - 1] ?? 0);
  const selected = new Set(report.shown.length > 0 ? report.shown : firstSelection(report.channels));
  const changed = () => {
    plots.show([...selected].sort((a, b) => a - b));
    list.refresh();
  };
  const plots = new Plots(report, clock, (channel) => {
    selected.delete(channel);
    changed();
  });
  const list = new ChannelList(report.channels, selected, changed);
  const reset = element("button", { title: "Show the whole time (or double-click a plot)" }, "Reset zoom");
  reset.addEventListener("click", () => plots.resetZoom());

  page.append(
    header(report),
    element(
      "main",
      {},
      new Player(report, clock).root,
      element(
        "section",
        { class: "card charts" },
        element("div", { class: "row" }, element("h2", {}, "Channels"), reset),
        list.root,
        element("p", { class: "hint" }, "Drag across a plot to zoom, double-click to see all, click to set the animation's time."),
        plots.root,
      ),
      summary(report),
      model(report),
    ),
  );
  changed();
  return clock;
}

function build(page: HTMLElement): void {
  const packed = JSON.parse(document.getElementById("mimbre-data")!.textContent!) as PackedReport | PackedComparison | PackedModes;
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
    document.title = `${report.title || "Untitled model"} – mimbre report`;
    clock = buildReport(page, report);
  }
  // report.html#t=4.3 opens at that time: a link can point at what is worth seeing.
  const start = Number(new URLSearchParams(location.hash.slice(1)).get("t") ?? NaN);
  if (Number.isFinite(start)) clock.set(start);
}

const page = document.getElementById("page")!;
try {
  build(page);
} catch (error) {
  console.error(error);
  page.append(element("p", { class: "warning", role: "alert" }, `This report cannot be shown: ${error instanceof Error ? error.message : error}`));
}
