// The facts of each run of a comparison, from its summary.
import type { Run } from "./comparisonData";
import { formatNumber } from "./format";
import { instant, quantity } from "./summaryLines";

type Summary = Record<string, unknown>;

function asSummary(run: Run): Summary | null {
  return typeof run.summary === "object" && run.summary !== null ? (run.summary as Summary) : null;
}

/** The run's last instant, NaN for a run without any. */
export function endOf(run: Run): number {
  return run.time[run.time.length - 1] ?? NaN;
}

/** Whether the run came to its end. */
export function isSound(run: Run): boolean {
  const summary = asSummary(run);
  return summary !== null && (summary.status === undefined || summary.status === "ok");
}

export interface Remark {
  text: string;
  warning: boolean;
}

/** A sentence for each run that failed or ended before others. */
export function remarks(runs: Run[]): Remark[] {
  const latest = Math.max(...runs.map(endOf).filter(Number.isFinite));
  return runs.flatMap((run): Remark[] => {
    const end = endOf(run);
    if (!Number.isFinite(end)) return [{ text: `${run.label} contains no instants.`, warning: true }];
    const upTo = `drawn up to ${instant(end, 5)}`;
    const summary = asSummary(run);
    if (!isSound(run)) {
      const status = summary ? String(summary.status) : "was cut short";
      const message = summary?.message ? `: ${summary.message}` : "";
      return [{ text: `${run.label} ${status}, ${upTo}${message}`, warning: true }];
    }
    // Runs that end together may differ by rounding.
    return latest - end > 1e-9 * Math.abs(latest) ? [{ text: `${run.label} ends earlier, ${upTo}.`, warning: false }] : [];
  });
}

interface Column {
  title: string;
  /** null where it is not known */
  value: (run: Run, summary: Summary) => string | null;
}

const number = (value: unknown, unit = "", digits = 4) => (typeof value === "number" ? formatNumber(value, digits) + unit : null);

const columns: Column[] = [
  { title: "Coordinates", value: (_, summary) => number(summary.coordinates) },
  { title: "CPU time", value: (_, summary) => number(summary.cpu_seconds, " s", 3) },
  { title: "Real-time factor", value: (_, summary) => number(summary.real_time_factor, "", 3) },
  { title: "Iterations per step", value: (_, summary) => number(summary.iterations_per_step, "", 3) },
  { title: "Step", value: (run) => quantity(run.step, "s", 5) },
  { title: "End", value: (run) => (Number.isFinite(endOf(run)) ? instant(endOf(run), 5) : "–") },
  { title: "Method", value: (_, summary) => [summary.formulation, summary.formalism, summary.integrator].filter((name) => typeof name === "string").join(", ").replace(/_/g, " ") || null },
  { title: "File", value: (run) => run.file },
];

/** Of the columns of which something is known, titles and one row per run. */
export function runTable(runs: Run[]): { titles: string[]; rows: string[][] } {
  const values = columns.map((column) => runs.map((run) => column.value(run, asSummary(run) ?? {})));
  const known = [...columns.keys()].filter((k) => values[k].some((value) => value !== null));
  return {
    titles: known.map((k) => columns[k].title),
    rows: runs.map((_, r) => known.map((k) => values[k][r] ?? "–")),
  };
}
