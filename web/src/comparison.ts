// The page of several runs.
import { ChannelList } from "./channelList";
import { Clock } from "./clock";
import type { Comparison, Run } from "./comparisonData";
import { element } from "./dom";
import { flatten, formatNumber } from "./format";
import { firstSelection, unitLabel } from "./groups";
import { Overlays, runColor } from "./overlays";
import { table } from "./panels";
import { Player } from "./player";
import { isSound, remarks, runTable } from "./runFacts";

function swatch(run: number): HTMLElement {
  const made = element("span", { class: "swatch" });
  made.style.background = runColor(run);
  return made;
}

export function comparisonTitle({ runs }: Comparison): string {
  const titles = [...new Set(runs.map((run) => run.title || "Untitled model"))];
  return titles.length > 3 ? `${titles.slice(0, 3).join(", ")}, …` : titles.join(", ");
}

function header(comparison: Comparison): HTMLElement {
  const { runs, channels } = comparison;
  const count = `${channels.length} ${channels.length === 1 ? "channel" : "channels"} in common`;
  const made = element(
    "header",
    {},
    element("h1", {}, comparisonTitle(comparison)),
    element("p", {}, `${runs.length} runs · ${count} · compared with ${runs[0].label}`),
  );
  for (const { text, warning } of remarks(runs))
    made.append(element("p", warning ? { class: "warning", role: "alert" } : { class: "note" }, text));
  if (runs.some((run) => run.time.length < run.instants))
    made.append(element("p", { class: "note" }, "The plots show the smallest and largest values of short stretches; the deviations are of all instants."));
  return made;
}

function runsTable(runs: Run[]): HTMLElement {
  const { titles, rows } = runTable(runs);
  const head = element("tr", {}, ...["Run", ...titles].map((title) => element("th", { scope: "col" }, title)));
  const body = rows.map((cells, r) =>
    element(
      "tr",
      { class: isSound(runs[r]) ? "" : "warning" },
      element("th", { scope: "row" }, swatch(r), runs[r].label),
      ...cells.map((cell) => element("td", {}, cell)),
    ),
  );
  return element("div", { class: "scroll" }, element("table", { class: "wide" }, element("thead", {}, head), element("tbody", {}, ...body)));
}

function deviationsTable({ runs, channels }: Comparison): HTMLElement {
  const others = runs.slice(1);
  const heads = element(
    "tr",
    {},
    element("th", { scope: "col" }, "Channel"),
    ...others.map((run, k) => element("th", { scope: "col" }, swatch(k + 1), run.label)),
  );
  const rows = channels.map((channel) => {
    const cells = others.map((_, k) => {
      const deviation = channel.deviations[k + 1];
      if (!deviation) return element("td", {}, "–");
      const { mean, largest, at, amplitude } = deviation;
      const text = (value: number | null) => formatNumber(value ?? NaN, 3);
      const relative = mean !== null && largest !== null && amplitude ? `; of the largest value ${formatNumber((100 * largest) / amplitude, 3)} %` : "";
      return element("td", { title: `Largest at ${formatNumber(at)} s${relative}` }, `${text(mean)} / ${text(largest)}`);
    });
    return element("tr", {}, element("th", { scope: "row", title: channel.meaning }, `${channel.name}, ${unitLabel(channel.unit)}`), ...cells);
  });
  return element("div", { class: "scroll" }, element("table", { class: "wide" }, element("thead", {}, heads), element("tbody", {}, ...rows)));
}

function tables(comparison: Comparison): HTMLElement {
  return element(
    "section",
    { class: "card summary" },
    element("h2", {}, "Runs"),
    runsTable(comparison.runs),
    element("h2", { class: "next" }, `Mean / largest deviation from ${comparison.runs[0].label}`),
    element("p", { class: "hint" }, "Absolute, over the time that both runs have, on the instants of the coarser one."),
    deviationsTable(comparison),
  );
}

function models(runs: Run[]): HTMLElement {
  const made = element("details", { class: "card model" }, element("summary", {}, element("h2", {}, "Models")));
  const texts = new Map<string, Run[]>();
  for (const run of runs) {
    const options = flatten(run.options ?? {});
    if (options.length > 0) made.append(element("h3", {}, `Options and parameters of ${run.label}`), table(options));
    texts.set(run.model, [...(texts.get(run.model) ?? []), run]);
  }
  for (const [text, of] of texts) {
    const whose = texts.size > 1 ? ` of ${of.map((run) => run.label).join(", ")}` : "";
    made.append(element("h3", {}, `Model file${whose}`), element("pre", { tabindex: 0 }, text || "(not in the results)"));
  }
  return made;
}

/** Buttons that hide and show runs; the legend of all plots. */
function legend(runs: Run[], overlays: Overlays): HTMLElement {
  const buttons = runs.map((run, r) => {
    const button = element("button", { class: "run", "aria-pressed": "true", title: "Hide or show this run" }, swatch(r), run.label);
    button.addEventListener("click", () => {
      const visible = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", String(visible));
      overlays.showRun(r, visible);
    });
    return button;
  });
  return element("div", { class: "legend runs", role: "group", "aria-label": "Runs" }, ...buttons);
}

/** Fills the page; returns the clock of its animation, the first run's. */
export function buildComparison(page: HTMLElement, comparison: Comparison): Clock {
  const { runs, channels } = comparison;
  const { time } = comparison.animation;
  const clock = new Clock(time[0] ?? 0, time[time.length - 1] ?? 0);
  const selected = new Set(comparison.shown.length > 0 ? comparison.shown : firstSelection(channels));
  const changed = () => {
    overlays.show([...selected].sort((a, b) => a - b));
    list.refresh();
  };
  const overlays = new Overlays(comparison, clock, (channel) => {
    selected.delete(channel);
    changed();
  });
  const list = new ChannelList(channels, selected, changed);
  const reset = element("button", { title: "Show the whole time (or double-click a plot)" }, "Reset zoom");
  reset.addEventListener("click", () => overlays.resetZoom());
  const differences = element("input", { type: "checkbox" });
  differences.checked = true;
  differences.addEventListener("change", () => overlays.showDifferences(differences.checked));
  const player = new Player(comparison, clock).root;
  player.append(element("p", { class: "hint" }, `The animation is of ${runs[0].label}.`));

  page.append(
    header(comparison),
    element(
      "main",
      {},
      player,
      element(
        "section",
        { class: "card charts" },
        element("div", { class: "row" }, element("h2", {}, "Channels"), element("label", { class: "row" }, differences, "Differences"), reset),
        list.root,
        element("p", { class: "hint" }, "Drag across a plot to zoom, double-click to see all, click to set the animation's time."),
        legend(runs, overlays),
        overlays.root,
      ),
      tables(comparison),
      models(runs),
    ),
  );
  changed();
  return clock;
}
