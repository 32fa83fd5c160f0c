// Curves as comma-separated values.
import type { Trace } from "./trace";

/** A field that spreadsheets take as text and nothing else: quoted, and no formula. */
export function field(text: string): string {
  const safe = /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
  return /[",\n\r;]/.test(safe) || safe !== text ? `"${safe.replace(/"/g, '""')}"` : safe;
}

/** One column of time and one per curve; a row for every instant that any curve has in [from, to]. */
export function csv(traces: Trace[], from = -Infinity, to = Infinity): string {
  const instants = new Set<number>();
  for (const { time } of traces) for (const t of time) if (t >= from && t <= to) instants.add(t);
  const rows = new Map([...instants].sort((a, b) => a - b).map((t) => [t, [String(t), ...traces.map(() => "")]]));
  traces.forEach(({ time, values }, k) => {
    time.forEach((t, i) => {
      const row = rows.get(t);
      const value = values[i];
      if (row && value !== null) row[k + 1] = String(value);
    });
  });
  const heads = traces.map(({ label, unit }) => field(unit === "" || unit === "1" ? label : `${label} [${unit}]`));
  return [["t [s]", ...heads], ...rows.values()].map((row) => row.join(",")).join("\r\n") + "\r\n";
}
