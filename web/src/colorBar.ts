// The scale of the colours, over the 3D view.
import { turboGradient } from "./color";
import { atNode, type Peak, type Quantity } from "./coloring";
import type { Body } from "./data";
import { element } from "./dom";
import { scaleFor } from "./engineering";
import { formatNumber } from "./format";
import { instant } from "./summaryLines";

export const quantityNames: Record<Quantity, string> = { none: "off", displacement: "deformation", stress: "von Mises stress" };

/** A number with its unit. */
export function quantityText(value: number, quantity: Quantity, digits = 3): string {
  const { unit, size } = scaleFor(quantity === "stress" ? "Pa" : "m", value);
  return `${formatNumber(value / size, digits)} ${unit}`;
}

export class ColorBar {
  readonly root: HTMLElement;
  private caption = element("span");
  private ends = [0, 1, 2].map(() => element("span"));
  private remark = element("small");

  constructor() {
    const bar = element("div", { class: "bar" });
    bar.style.background = turboGradient("to right");
    const title = "Displacement of the points of flexible bodies from their undeformed shape, or stress there; true values, not exaggerated";
    this.root = element("div", { class: "colorbar", title }, this.caption, bar, element("div", { class: "ends" }, ...this.ends), this.remark);
  }

  hide(): void {
    this.root.hidden = true;
  }

  /** A scale from 0 to `largest`; `note` follows the unit. */
  show(quantity: Quantity, largest: number, remark = "", note = ""): void {
    const { unit, size } = scaleFor(quantity === "stress" ? "Pa" : "m", largest);
    const name = quantityNames[quantity];
    this.fill(`${name}, ${unit}${note}`, [0, largest / 2, largest].map((value) => formatNumber(value / size, 3)), remark);
  }

  /** A scale of each body's own. */
  showRelative(quantity: Quantity): void {
    this.fill(`${quantityNames[quantity]}, relative to each body's largest`, ["0", "50 %", "100 %"], "");
  }

  private fill(caption: string, ends: string[], remark: string): void {
    this.root.hidden = false;
    this.caption.textContent = caption.charAt(0).toUpperCase() + caption.slice(1);
    this.ends.forEach((end, k) => (end.textContent = ends[k]));
    this.remark.textContent = remark;
  }
}

/** Sizes in the view: of the grid, and by how much deformations are exaggerated. */
export function viewNote(cell: number, exaggeration: number): string {
  const { unit, size } = scaleFor("m", 10 * cell); // 0.5 m rather than 500 mm
  return `Grid ${formatNumber(cell / size)} ${unit}${exaggeration > 1 ? ` · Deformations drawn ${formatNumber(exaggeration)} times larger` : ""}`;
}

/** Where the largest is: body, node, time, as far as they are known. */
export function peakText(bodies: Body[], peak: Peak & { body: number }, quantity: Quantity): string {
  const body = bodies[peak.body];
  return body ? `Largest: ${quantityText(peak.value, quantity)} in ${body.name}${atNode(body, peak.point)} at ${instant(peak.time)}` : "";
}
