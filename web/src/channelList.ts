// The list in which channels are searched and ticked.
import type { ChannelName } from "./data";
import { element } from "./dom";
import { grouped, unitLabel, type Grouping } from "./groups";

export class ChannelList {
  readonly root: HTMLElement;
  private list = element("div", { class: "channel-groups" });
  private search = element("input", {
    type: "search",
    placeholder: "Search name, unit or meaning",
    "aria-label": "Search channels",
  });
  private grouping = element(
    "select",
    { "aria-label": "Group channels by" },
    element("option", { value: "name" }, "by name"),
    element("option", { value: "unit" }, "by unit"),
  );
  private open = new Set<string>();
  private refreshers: (() => void)[] = [];

  constructor(
    private channels: ChannelName[],
    private selected: Set<number>,
    private changed: () => void,
  ) {
    const none = element("button", { title: "Untick all channels" }, "Clear");
    none.addEventListener("click", () => {
      this.selected.clear();
      this.changed();
    });
    this.search.addEventListener("input", () => this.draw());
    this.grouping.addEventListener("change", () => this.draw());
    this.root = element("div", { class: "channels" }, element("div", { class: "row" }, this.search, this.grouping, none), this.list);
    this.draw();
  }

  /** Ticks and counts follow the selection; nothing is rebuilt, so that the keyboard's place is kept. */
  refresh(): void {
    for (const refresher of this.refreshers) refresher();
  }

  /** There are more channels than before. */
  redraw(): void {
    this.draw();
  }

  private draw(): void {
    this.refreshers = [];
    const groups = grouped(this.channels, this.grouping.value as Grouping, this.search.value);
    const open = this.search.value.trim() !== "" || groups.size === 1;
    this.list.replaceChildren(...[...groups].map(([name, members]) => this.group(name, members, open)));
    if (groups.size === 0) this.list.append(element("p", { class: "hint" }, this.channels.length > 0 ? "No channel matches all these words." : "The results contain no channels."));
    this.refresh();
  }

  private group(name: string, members: number[], open: boolean): HTMLElement {
    const count = element("small");
    this.refreshers.push(() => {
      const ticked = members.filter((index) => this.selected.has(index)).length;
      count.textContent = ticked > 0 ? `${ticked} of ${members.length}` : String(members.length);
    });
    const details = element("details", {}, element("summary", {}, element("span", {}, name), count));
    // Hundreds of channels: entries are made when they are first seen.
    const fill = () => {
      if (details.childElementCount === 1) details.append(...members.map((index) => this.entry(index)));
    };
    details.open = open || this.open.has(name);
    if (details.open) fill();
    details.addEventListener("toggle", () => {
      if (details.open) {
        this.open.add(name);
        fill();
      } else this.open.delete(name);
    });
    return details;
  }

  private entry(index: number): HTMLElement {
    const channel = this.channels[index];
    const box = element("input", { type: "checkbox" });
    const refresh = () => (box.checked = this.selected.has(index));
    refresh();
    this.refreshers.push(refresh);
    box.addEventListener("change", () => {
      if (box.checked) this.selected.add(index);
      else this.selected.delete(index);
      this.changed();
    });
    return element("label", { title: channel.meaning }, box, element("span", {}, channel.name), element("small", {}, unitLabel(channel.unit)));
  }
}
