// The page of a mechanism's modes: the list, and the mechanism moving in one of them.
import { element } from "./dom";
import { MechanismModeList } from "./mechanismModeList";
import { MechanismModePlayer } from "./mechanismModePlayer";
import { remarks, type MechanismModes } from "./mechanismModesData";
import { warningList } from "./panels";

/** Fills the page. */
export function buildMechanismModes(page: HTMLElement, report: MechanismModes): void {
  const growing = report.modes.filter(({ grows }) => grows).length;
  const facts = [`Point: ${report.point}`, `${report.modes.length} mode${report.modes.length === 1 ? "" : "s"}`, ...(growing > 0 ? [`${growing} of them grow${growing === 1 ? "s" : ""}`] : [])];
  const player = new MechanismModePlayer(report);
  const list = new MechanismModeList(report, (mode) => player.show(mode));
  page.append(
    element("header", {}, element("h1", {}, `${report.title || "Untitled model"}: modes`), element("p", {}, facts.join(" · ")), ...warningList(report.warnings)),
    element("main", { class: "modes mechanism" }, player.root, list.root, notes(remarks(report)), model(report.model)),
  );
  // modes.html#mode=3 opens with that one.
  const asked = new URLSearchParams(location.hash.slice(1)).get("mode");
  list.choose(asked === null ? firstTelling(report) : Number(asked) - 1);
}

/** The first that is not rigid. */
function firstTelling({ modes }: MechanismModes): number {
  return Math.max(modes.findIndex(({ kind }) => kind !== "rigid"), 0);
}

function notes(texts: string[]): HTMLElement {
  const how = "Each mode is drawn with its largest displacement as the share of the mechanism's size that the slider states; its amplitude is arbitrary.";
  return element("section", { class: "card summary" }, element("h2", {}, "Notes"), element("ul", {}, ...[...texts, how].map((text) => element("li", {}, text))));
}

function model(text: string): HTMLElement {
  return element("details", { class: "card model" }, element("summary", {}, element("h2", {}, "Model file")), element("pre", { tabindex: 0 }, text || "(not in the page)"));
}
