// The parts of the page that only show text.
import type { Report } from "./data";
import { element } from "./dom";
import { flatten, formatNumber, type SummaryLine } from "./format";
import { isJoint } from "./placement";
import { summaryLines, warningsOf, type Line } from "./summaryLines";

const fewWarnings = 3; // shown at once; the rest are folded

/** Above everything else on the page. */
export function warningList(warnings: string[]): HTMLElement[] {
  const item = (text: string) => element("li", {}, text);
  if (warnings.length === 0) return [];
  const made = element("section", { class: "warnings", role: "alert", "aria-label": "Warnings" }, element("ul", {}, ...warnings.slice(0, fewWarnings).map(item)));
  if (warnings.length > fewWarnings)
    made.append(element("details", {}, element("summary", {}, `${warnings.length - fewWarnings} more`), element("ul", {}, ...warnings.slice(fewWarnings).map(item))));
  return [made];
}

export function header(report: Report): HTMLElement {
  const made = element("header", {}, element("h1", {}, report.title || "Untitled model"));
  const warnings = report.summary === null ? ["This run was cut short: the results end early and have no summary."] : warningsOf(report.summary);
  made.append(...warningList(warnings));
  if (report.time.length < report.instants)
    made.append(element("p", { class: "note" }, "The plots show minima and maxima over short intervals. The results file contains every instant."));
  return made;
}

export function table(lines: (SummaryLine | Line)[]): HTMLElement {
  const rows = lines.map((line) => {
    const warning = "warning" in line && line.warning;
    return element("tr", { class: warning ? "warning" : "" }, element("th", { scope: "row" }, line.label), element("td", {}, (warning ? "⚠ " : "") + line.value));
  });
  return element("table", {}, element("tbody", {}, ...rows));
}

/** A dozen lines; every figure of the run is in a fold. */
export function summary(report: Report): HTMLElement {
  const { time } = report.animation;
  const facts = {
    end: time.length > 0 ? time[time.length - 1] : NaN,
    step: report.step,
    instants: report.instants,
    bodies: report.bodies.length,
    joints: report.elements.filter((element) => isJoint(element) || element.kind === "floating").length,
  };
  const made = element("section", { class: "card summary" }, element("h2", {}, "Summary"), table(summaryLines(report.summary, facts)));
  const details = flatten(report.summary ?? {}).map((line) => ({ ...line, warning: false }));
  if (details.length > 0) {
    const folded = element("details", { class: "all" }, element("summary", {}, `All ${formatNumber(details.length)} figures of the run (SI units)`));
    // Hundreds of rows: made when they are first seen.
    folded.addEventListener("toggle", () => folded.open && folded.childElementCount === 1 && folded.append(table(details)));
    made.append(folded);
  }
  return made;
}

export function model(report: Report): HTMLElement {
  const options = flatten(report.options ?? {});
  const made = element("details", { class: "card model" }, element("summary", {}, element("h2", {}, "Model")));
  if (options.length > 0) made.append(element("h3", {}, "Options and parameters"), table(options));
  made.append(element("h3", {}, "Model file"), element("pre", { tabindex: 0 }, report.model || "(not in the results)"));
  return made;
}
