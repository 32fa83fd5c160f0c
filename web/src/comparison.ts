// The page of several runs.
import { channelCard } from "./channelViews";
import { Clock } from "./clock";
import type { Comparison, Run } from "./comparisonData";
import { element } from "./dom";
import { flatten, formatNumber } from "./format";
import { formulaChannel } from "./formulas";
import { firstSelection, unitLabel } from "./groups";
import { Overlays, runColor } from "./overlays";
import { table, warningList } from "./panels";
import { Player } from "./player";
import { isSound, remarks, runTable } from "./runFacts";
import { instant, warningsOf } from "./summaryLines";
import type { Trace } from "./trace";

function swatch(run: number): HTMLElement {
  const made = element("span", { class: "swatch" });
  made.style.setProperty("--line", runColor(run));
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
  made.append(...warningList(runs.flatMap((run) => (isSound(run) ? warningsOf(run.summary).map((text) => `${run.label}: ${text}`) : []))));
  if (runs.some((run) => run.time.length < run.instants))
    made.append(element("p", { class: "note" }, "The plots show minima and maxima over short intervals; the deviations use every instant."));
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
      ...cells.map((cell, k) => element("td", { class: titles[k] === "Method" ? "words" : "" }, cell)),
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
      return element("td", { title: `Largest at ${instant(at)}${relative}` }, `${text(mean)} / ${text(largest)}`);
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
    element("p", { class: "hint" }, "Absolute values over the time common to both runs, at the instants of the coarser run."),
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

/** Buttons that hide and show runs, in the plots and in the animation; the legend of all plots. */
function legend(runs: Run[], showRun: (run: number, visible: boolean) => void): HTMLElement {
  const buttons = runs.map((run, r) => {
    const button = element("button", { class: "run", "aria-pressed": "true", title: "Hide or show this run" }, swatch(r), run.label);
    button.addEventListener("click", () => {
      const visible = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", String(visible));
      showRun(r, visible);
    });
    return button;
  });
  return element("div", { class: "legend runs", role: "group", "aria-label": "Runs" }, ...buttons);
}

/** The formula of every run that has its channels. */
function addFormula(comparison: Comparison, text: string): number {
  const { runs, channels } = comparison;
  let wrong: unknown = null;
  const made = runs.map((run, r) => {
    const channel = (name: string) => {
      const found = channels.find((one) => one.name === name && one.curves[r]);
      return found ? { values: found.curves[r]!.values, unit: found.unit } : null;
    };
    try {
      return formulaChannel(text, { time: run.time, channel });
    } catch (error) {
      wrong ??= error;
      return null;
    }
  });
  const first = made.find((channel) => channel !== null);
  if (!first) throw wrong;
  const nothing = runs.map(() => null);
  const { name, unit, meaning } = first;
  return channels.push({ name, unit, meaning, curves: made, differences: nothing, deviations: nothing }) - 1;
}

/** Fills the page; returns the clock of its animation, which lasts as long as the longest run. */
export function buildComparison(page: HTMLElement, comparison: Comparison): Clock {
  const { runs, channels, ghosts } = comparison;
  const ends = [comparison, ...ghosts].map(({ animation }) => animation.time).filter((time) => time.length > 0);
  const clock = new Clock(Math.min(...ends.map((time) => time[0]), Infinity), Math.max(...ends.map((time) => time[time.length - 1]), -Infinity), Math.max(...ends.map(({ length }) => length), 0));
  const sound = Number.isFinite(clock.start) ? clock : new Clock(0, 0);
  const player = new Player(comparison, sound, { ghosts: ghosts.map((scene, r) => ({ scene, color: runColor(r + 1) })) });
  if (player.view && ghosts.length > 0) player.root.append(element("p", { class: "hint" }, `Solid: ${runs[0].label}. See-through, in the colours of their curves: the other runs.`));

  const hidden = new Set<number>();
  const traces = (selection: number[]): Trace[] =>
    selection.flatMap((channel) =>
      channels[channel].curves.flatMap((curve, run): Trace[] => {
        const { name, unit, meaning } = channels[channel];
        if (!curve || hidden.has(run)) return [];
        return [{ name, unit, meaning, ...curve, channel, run, label: `${name}, ${runs[run].label}`, color: runColor(run), time: runs[run].time }];
      }),
    );
  const differences = element("input", { type: "checkbox" });
  differences.checked = true;
  const charts = channelCard({
    curves: { channels, traces },
    clock: sound,
    start: comparison.shown.length > 0 ? comparison.shown : firstSelection(channels),
    thinned: runs.some((run) => run.time.length < run.instants),
    addFormula: (text) => addFormula(comparison, text),
    extras: [element("label", { class: "row" }, differences, "Differences")],
    overTime: (remove) => {
      const overlays = new Overlays(comparison, sound, remove);
      differences.addEventListener("change", () => overlays.showDifferences(differences.checked));
      return overlays;
    },
    legend: (time) =>
      legend(runs, (run, visible) => {
        if (visible) hidden.delete(run);
        else hidden.add(run);
        (time as Overlays).showRun(run, visible);
        if (run === 0) player.view?.showBodies(visible);
        else player.view?.showGhost(run - 1, visible);
      }),
  });

  page.append(header(comparison), element("main", {}, element("div", { class: "column" }, player.root, tables(comparison), models(runs)), charts));
  return sound;
}
