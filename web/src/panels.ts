// The parts of the page that only show text.
import type { Report } from "./data";
import { element } from "./dom";
import { flatten, formatNumber, type SummaryLine } from "./format";

export function header(report: Report): HTMLElement {
  const { time } = report.animation;
  const facts: string[] = [];
  if (time.length > 0) facts.push(`${formatNumber(time[time.length - 1] - time[0])} s simulated`);
  const count = (number: number, one: string, many: string) => `${formatNumber(number)} ${number === 1 ? one : many}`;
  facts.push(`step ${formatNumber(report.step * 1000)} ms`, count(report.instants, "instant", "instants"));
  facts.push(count(report.bodies.length, "body", "bodies"), count(report.channels.length, "channel", "channels"));
  const made = element(
    "header",
    {},
    element("h1", {}, report.title || "Untitled model"),
    element("p", {}, facts.join(" · ")),
  );
  if (report.summary === null)
    made.append(element("p", { class: "warning", role: "alert" }, "This run was cut short: the results end early and have no summary."));
  if (report.time.length < report.instants)
    made.append(element("p", { class: "note" }, "The plots show the smallest and largest values of short stretches, the results file all instants."));
  return made;
}

export function table(lines: SummaryLine[]): HTMLElement {
  const rows = lines.map(({ label, value, warning }) =>
    element("tr", { class: warning ? "warning" : "" }, element("th", { scope: "row" }, label), element("td", {}, (warning ? "⚠ " : "") + value)),
  );
  return element("table", {}, element("tbody", {}, ...rows));
}

export function summary(report: Report): HTMLElement {
  const lines = flatten(report.summary ?? {});
  const ordered = [...lines.filter((line) => line.warning), ...lines.filter((line) => !line.warning)];
  const body = lines.length > 0 ? table(ordered) : element("p", { class: "hint" }, "The results have no summary.");
  return element("section", { class: "card summary" }, element("h2", {}, "Summary"), body);
}

export function model(report: Report): HTMLElement {
  const options = flatten(report.options ?? {});
  const made = element("details", { class: "card model" }, element("summary", {}, element("h2", {}, "Model")));
  if (options.length > 0) made.append(element("h3", {}, "Options and parameters"), table(options));
  made.append(element("h3", {}, "Model file"), element("pre", { tabindex: 0 }, report.model || "(not in the results)"));
  return made;
}
