// The card with the channels: the list, formulas, and four ways to look at what is chosen.
import { ChannelList } from "./channelList";
import type { Clock } from "./clock";
import { csv } from "./csv";
import { element } from "./dom";
import { fileName, save, saveCanvas } from "./download";
import { pictureOf } from "./plotPicture";
import type { View } from "./plots";
import { SpectrumPlots } from "./spectrumPlots";
import { StatisticsTable } from "./statisticsTable";
import { tabs } from "./tabs";
import type { Curves, Range } from "./trace";
import { XyPlot } from "./xyPlot";

/** The view over time knows which part of it is shown. */
export interface TimeView extends View {
  readonly visible: Range;
  resetZoom(): void;
}

export interface ChannelCard {
  root: HTMLElement;
  /** Unticks a channel. */
  remove: (channel: number) => void;
}

export interface CardOptions {
  curves: Curves;
  clock: Clock;
  start: number[];
  /** The curves are thinned: the page does not hold all instants. */
  thinned: boolean;
  overTime: (remove: (channel: number) => void) => TimeView;
  /** Adds a channel; throws an Error that describes the mistake in the formula. */
  addFormula: (text: string) => number;
  /** Above the views, beside the buttons. */
  extras?: HTMLElement[];
  /** Between the list and the views. */
  legend?: (time: TimeView) => HTMLElement;
}

export function channelCard(options: CardOptions): HTMLElement {
  const { curves, clock } = options;
  const selected = new Set(options.start);
  const sorted = () => [...selected].sort((a, b) => a - b);
  const changed = () => {
    shown().show(sorted());
    list.refresh();
  };
  const remove = (channel: number) => {
    selected.delete(channel);
    changed();
  };
  const time = options.overTime(remove);
  const visible = () => time.visible;
  const across = new XyPlot(curves, visible, clock, remove);
  const views: [string, View][] = [
    ["Over time", time],
    ["x–y", across],
    ["Spectrum", new SpectrumPlots(curves, visible, remove)],
    ["Table", new StatisticsTable(curves, visible, options.thinned)],
  ];
  const chosen = tabs("Ways to look at the channels", views.map(([name, view]) => [name, view.root]), () => shown().show(sorted()));
  const shown = () => views[chosen.current()][1];
  const list = new ChannelList(curves.channels, selected, changed);

  const button = (text: string, title: string, pressed: () => void) => {
    const made = element("button", { title }, text);
    made.addEventListener("click", pressed);
    return made;
  };
  const table = button("Save CSV", "The selected channels over the visible interval, with every instant in this page", () => {
    const { min, max } = time.visible;
    save(fileName("channels", "csv"), new Blob([csv(curves.traces(sorted()), min, max)], { type: "text/csv" }));
  });
  const picture = button("Save plots", "Save the charts as PNG", () => {
    const canvas = pictureOf(shown().root);
    if (canvas) saveCanvas(canvas, "plots");
  });
  const reset = button("Reset zoom", "Show the whole run in all plots (or double-click a plot)", () => {
    time.resetZoom();
    across.resetZoom();
  });

  chosen.panels[0].prepend(element("p", { class: "hint" }, "Drag across a plot to zoom, double-click to show all, click to move the animation there."));
  const card = element(
    "section",
    { class: "card charts" },
    element("div", { class: "row heading" }, element("h2", {}, "Channels"), ...(options.extras ?? []), reset, table, picture),
    list.root,
    formulaBox(options.addFormula, (channel) => {
      selected.add(channel);
      list.redraw();
      changed();
    }),
    chosen.bar,
    ...(options.legend ? [options.legend(time)] : []),
    ...chosen.panels,
  );
  changed();
  return card;
}

/** A line for a formula; its mistake is printed below. */
function formulaBox(add: (text: string) => number, added: (channel: number) => void): HTMLElement {
  const input = element("input", { type: "text", class: "formula", placeholder: "Formula, such as tip.z - 2*arm.z", "aria-label": "Formula over channels", spellcheck: "false", autocomplete: "off" });
  const draw = element("button", { type: "submit" }, "Draw");
  const wrong = element("p", { class: "wrong", role: "alert" });
  const hint =
    "Channel names (in backquotes if they contain characters other than letters, digits and dots), t, pi, + − * / ^, and abs sqrt exp ln log10 sin cos tan asin acos atan atan2 min max hypot, ddt(…) for the time derivative and int(…) for the time integral; in radians, metres, newtons";
  input.title = hint;
  const form = element("form", { class: "row formulas" }, input, draw);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    wrong.textContent = "";
    if (input.value.trim() === "") return;
    try {
      added(add(input.value.trim()));
      input.value = "";
    } catch (error) {
      wrong.textContent = error instanceof Error ? error.message : String(error);
    }
  });
  return element("div", {}, form, wrong);
}
