// The list of a mechanism's modes, one of them chosen.
import { element } from "./dom";
import { formatNumber } from "./format";
import type { MechanismMode, MechanismModes } from "./mechanismModesData";

const roundOff = 1e-9; // of |λ|

/** −Re λ/|λ|; of a rigid mode there is none. */
export function dampingText({ kind, damping }: MechanismMode): string {
  if (kind === "rigid") return "–";
  return formatNumber(Math.abs(damping) < roundOff ? 0 : damping, 4);
}

/** λ with both signs of its imaginary part. */
export function valueText({ value: [real, imaginary] }: Pick<MechanismMode, "value">): string {
  if (imaginary === 0) return formatNumber(real, 5);
  return `${Math.abs(real) <= roundOff * Math.abs(imaginary) ? "" : `${formatNumber(real, 5)} `}± ${formatNumber(Math.abs(imaginary), 5)} i`;
}

export class MechanismModeList {
  readonly root = element("section", { class: "card charts" });
  private holder: HTMLElement;
  private boxes: HTMLInputElement[];

  constructor(
    report: MechanismModes,
    private chosen: (mode: number) => void,
  ) {
    const turns = report.turning > 0;
    const heads = ["Mode", "Frequency, Hz", ...(turns ? ["From the ground, Hz"] : []), "Damping ratio", "Consists of"].map((title) => element("th", { scope: "col" }, title));
    const rows = report.modes.map((mode, k) => {
      const box = element("input", { type: "radio", name: "mode" });
      box.addEventListener("change", () => this.choose(k));
      const ground = mode.ground === undefined ? "two" : formatNumber(mode.ground / (2 * Math.PI), 5);
      const cells = [
        element("td", {}, element("label", {}, box, element("span", {}, String(k + 1)))),
        element("td", {}, formatNumber(mode.frequency, 5)),
        ...(turns ? [element("td", {}, ground)] : []),
        element("td", {}, dampingText(mode)),
        element("td", { class: "text" }, `${mode.grows ? "⚠ " : ""}${mode.text}`),
      ];
      return { box, row: element("tr", { class: mode.grows ? "warning" : "" }, ...cells) };
    });
    rows.forEach(({ row }, k) => row.addEventListener("click", () => this.choose(k)));
    this.boxes = rows.map(({ box }) => box);
    const table = element("table", { class: "wide modes mechanism" }, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...rows.map(({ row }) => row)));
    this.holder = element("div", { class: "scroll", role: "radiogroup", "aria-label": "Mode" }, table);
    this.root.append(
      element("h2", {}, "Modes"),
      this.holder,
      element("p", { class: "hint" }, "Frequencies are |λ|/2π. ", element("kbd", {}, "↑"), " ", element("kbd", {}, "↓"), " select, ", element("kbd", {}, "Space"), " plays."),
    );
    document.addEventListener("keydown", (event) => this.key(event));
  }

  /** The first where there is no such one. */
  choose(mode: number): void {
    const box = this.boxes[mode] ?? this.boxes[0];
    if (!box) return;
    box.checked = true;
    for (const other of this.boxes) other.closest("tr")!.classList.toggle("chosen", other === box);
    this.scrollTo(box.closest("tr")!);
    this.chosen(this.boxes.indexOf(box));
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
    if (event.target.closest("input:not([type=radio]), select, textarea, summary, pre, canvas")) return;
    const next = this.boxes.findIndex((box) => box.checked) + step;
    if (!this.boxes[next]) return;
    this.choose(next);
    event.preventDefault();
  }
}
