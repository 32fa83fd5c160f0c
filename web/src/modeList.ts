// The list of a body's modes, one of them chosen.
import { element } from "./dom";
import { formatNumber } from "./format";
import type { ModesReport } from "./modesData";
import { choice } from "./slider";

export class ModeList {
  readonly root = element("section", { class: "card charts" });
  private body = element("tbody");
  private holder: HTMLElement;
  private family = 0;
  private boxes: HTMLInputElement[] = [];

  constructor(
    private report: ModesReport,
    private chosen: (family: number, mode: number) => void,
  ) {
    const heads = ["Mode", "Frequency, Hz"].map((title) => element("th", { scope: "col" }, title));
    const table = element("table", { class: "wide modes" }, element("thead", {}, element("tr", {}, ...heads)), this.body);
    this.holder = element("div", { class: "scroll", role: "radiogroup", "aria-label": "Mode" }, table);
    this.root.append(
      element("h2", {}, "Modes"),
      element("div", { class: "settings" }),
      this.holder,
      element("p", { class: "hint" }, "Eigenmodes belong to the reduced matrices with the body frame fixed; other modes have the frequency of their Rayleigh quotient. The validation report has the frequencies of the free body. ", element("kbd", {}, "↑"), " ", element("kbd", {}, "↓"), " select, ", element("kbd", {}, "Space"), " plays."),
    );
    document.addEventListener("keydown", (event) => this.key(event));
  }

  /** Of the first family or mode where there is no such one. */
  select(family: number, mode: number): void {
    const { families } = this.report;
    this.family = families[family] ? family : 0;
    const settings = this.root.querySelector(".settings")!;
    const options = families.map(({ name, modes }, k) => ({ value: String(k), text: `${name} (${modes.length})` }));
    settings.replaceChildren(choice("Show", options, String(this.family), (value) => this.fill(Number(value), 0)));
    this.fill(this.family, families[this.family]?.modes[mode] ? mode : 0);
  }

  private fill(family: number, mode: number): void {
    this.family = family;
    const rows = this.report.families[family].modes.map(({ name, frequency }, k) => {
      const box = element("input", { type: "radio", name: "mode" });
      box.addEventListener("change", () => this.choose(k));
      const hertz = frequency === null ? "–" : formatNumber(frequency, 5);
      return { box, row: element("tr", {}, element("td", {}, element("label", {}, box, element("span", {}, name))), element("td", {}, hertz)) };
    });
    this.boxes = rows.map(({ box }) => box);
    this.body.replaceChildren(...rows.map(({ row }) => row));
    this.choose(mode);
  }

  private choose(mode: number): void {
    const box = this.boxes[mode];
    if (!box) return;
    box.checked = true;
    for (const other of this.boxes) other.closest("tr")!.classList.toggle("chosen", other === box);
    this.scrollTo(box.closest("tr")!);
    this.chosen(this.family, mode);
  }

  /** Within the list alone: the page stays where it is. */
  private scrollTo(row: HTMLElement): void {
    const above = row.offsetTop - 2 * row.offsetHeight;
    const below = row.offsetTop + row.offsetHeight - this.holder.clientHeight;
    if (this.holder.scrollTop > above) this.holder.scrollTop = above;
    else if (this.holder.scrollTop < below) this.holder.scrollTop = below;
  }

  private key(event: KeyboardEvent): void {
    const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (!step || event.ctrlKey || event.metaKey || event.altKey || !(event.target instanceof Element)) return;
    if (event.target.closest("input, select, textarea, summary, pre")) return;
    const next = this.boxes.findIndex((box) => box.checked) + step;
    if (!this.boxes[next]) return;
    this.choose(next);
    event.preventDefault();
  }
}
