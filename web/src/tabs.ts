// Several panels of which one is shown; as a screen reader knows them.
import { element } from "./dom";

export interface Tabs {
  bar: HTMLElement;
  panels: HTMLElement[];
  current: () => number;
}

let made = 0;

export function tabs(label: string, all: [name: string, content: HTMLElement][], changed: () => void): Tabs {
  const stem = `tabs${++made}`;
  let current = 0;
  const panels = all.map(([, content], k) => element("div", { role: "tabpanel", id: `${stem}p${k}`, "aria-labelledby": `${stem}t${k}` }, content));
  const buttons = all.map(([name], k) => element("button", { role: "tab", id: `${stem}t${k}`, "aria-controls": `${stem}p${k}` }, name));
  const show = (next: number, focus: boolean) => {
    current = next;
    buttons.forEach((button, k) => {
      button.setAttribute("aria-selected", String(k === current));
      button.tabIndex = k === current ? 0 : -1;
      panels[k].hidden = k !== current;
    });
    if (focus) buttons[current].focus();
  };
  buttons.forEach((button, k) => {
    button.addEventListener("click", () => (show(k, false), changed()));
    button.addEventListener("keydown", (event) => {
      const by = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
      if (by === 0) return;
      event.preventDefault();
      event.stopPropagation(); // elsewhere the arrows step through time
      show((current + by + all.length) % all.length, true);
      changed();
    });
  });
  show(0, false);
  return { bar: element("div", { class: "tabs", role: "tablist", "aria-label": label }, ...buttons), panels, current: () => current };
}
