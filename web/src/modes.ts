// The page of a reduced body: its modes and its validation report.
import type { Clock } from "./clock";
import { element } from "./dom";
import { formatNumber } from "./format";
import { ModeList } from "./modeList";
import { ModePlayer } from "./modePlayer";
import { ordered, verdict, type Check, type ModesReport } from "./modesData";
import { table } from "./panels";

const number = (value: number | null) => formatNumber(value ?? NaN, 6);
const mark = (check: Check) => (check.passed ? "✓ passed" : "✗ FAILED");

function header(report: ModesReport): HTMLElement {
  const { text, passed } = verdict(report.checks);
  const count = (values: number, one: string) => `${values} ${one}${values === 1 ? "" : "s"}`;
  const short = (value: number | null) => formatNumber(value ?? NaN, 4);
  const facts = [
    `${short(report.mass)} kg`,
    `centre of mass ${report.centre.map(short).join(", ")} m`,
    `inertia ${[0, 4, 8].map((k) => short(report.inertia[k])).join(", ")} kg m²`,
    count(report.body.modes, "mode"),
    `${count(report.frames.length, "interface")}${report.frames.length > 0 ? `: ${report.frames.map(({ name }) => name).join(", ")}` : ""}`,
  ];
  return element(
    "header",
    {},
    element("h1", {}, report.name || "Reduced body"),
    element("p", {}, facts.join(" · ")),
    element("p", passed ? { class: "passed" } : { class: "warning", role: "alert" }, `${passed ? "✓" : "⚠"} ${text}`),
  );
}

function validationReport(checks: Check[]): HTMLElement {
  const rows = ordered(checks).map((check) =>
    element(
      "tr",
      { class: check.passed ? "" : "warning" },
      element("td", { class: "mark" }, mark(check)),
      element("th", { scope: "row" }, check.name),
      element("td", { class: "detail" }, check.detail),
    ),
  );
  const heads = ["Result", "Check", "Detail"].map((title) => element("th", { scope: "col" }, title));
  const body =
    rows.length > 0
      ? element("table", { class: "validation" }, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...rows))
      : element("p", { class: "hint" }, "`mimbre reduce` adds checks to a body; this body has none.");
  return element("section", { class: "card summary" }, element("h2", {}, "Validation report"), body);
}

function facts(report: ModesReport): HTMLElement {
  const inertia = (row: number) => report.inertia.slice(3 * row, 3 * row + 3).map(number).join(",  ");
  const line = (label: string, value: string) => ({ label, value, warning: false });
  return element(
    "section",
    { class: "card model" },
    element("h2", {}, "Body"),
    table([
      line("Mass", `${number(report.mass)} kg`),
      line("Centre of mass", `${report.centre.map(number).join(",  ")} m`),
      ...["x", "y", "z"].map((axis, row) => line(`Inertia about the centre of mass, kg m², row ${axis}`, inertia(row))),
      ...report.frames.map(({ name, position }) => line(`Interface ${name}`, `${position.map(number).join(",  ")} m`)),
    ]),
  );
}

/** Fills the page; returns the clock of its animation. */
export function buildModes(page: HTMLElement, report: ModesReport): Clock {
  const player = new ModePlayer(report);
  const list = new ModeList(report, (family, mode) => player.show(family, mode));
  page.append(header(report), element("main", { class: "modes" }, player.root, list.root, validationReport(report.checks), facts(report)));
  // modes.html#family=2&mode=3 opens with that one.
  const asked = new URLSearchParams(location.hash.slice(1));
  list.select(Number(asked.get("family") ?? 1) - 1, Number(asked.get("mode") ?? 1) - 1);
  return player.clock;
}
