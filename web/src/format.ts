// Numbers and the summary as people read them.

export function formatNumber(value: number, digits = 5): string {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "not a number" : value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  let text: string;
  if (Number.isInteger(value) && size < 1e15) text = value.toLocaleString("en-US").replace(/,/g, "\u202f");
  else if (size >= 1e6 || size < 1e-4) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    text = `${mantissa.replace(/\.?0+$/, "")}·10${superscript(Number(exponent))}`;
  } else text = String(Number(value.toPrecision(digits)));
  return text.replace(/^-/, "−");
}

/** With as many digits as tell `range` / 10 000 apart: round-off of a channel that passes zero is not shown. */
export function formatWithin(range: number, value: number): string {
  if (!(range > 0) || !Number.isFinite(value)) return formatNumber(value);
  const unit = 10 ** Math.floor(Math.log10(range / 1e4));
  return formatNumber(Math.round(value / unit) * unit, 6);
}

function superscript(exponent: number): string {
  const digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  return (exponent < 0 ? "⁻" : "") + [...String(Math.abs(exponent))].map((digit) => digits[Number(digit)]).join("");
}

export interface SummaryLine {
  label: string;
  value: string;
  warning: boolean;
}

const units = new Map([["s", "s"], ["ms", "ms"], ["us", "µs"], ["m", "m"], ["mm", "mm"], ["kg", "kg"], ["hz", "Hz"], ["percent", "%"]]);
const listed = 20; // of a list's entries; the rest are only counted

/** "step_time_us" → label "Step time", unit "µs" */
export function splitKey(key: string): { label: string; unit: string } {
  const words = key.split(/[_\s]+/).filter((word) => word !== "");
  const unit = words.length > 1 ? units.get(words[words.length - 1].toLowerCase()) : undefined;
  if (unit) words.pop();
  const label = words.join(" ");
  return { label: label.charAt(0).toUpperCase() + label.slice(1), unit: unit ?? "" };
}

function formatScalar(value: unknown, unit: string): string {
  if (typeof value === "number") return formatNumber(value) + (unit ? ` ${unit}` : "");
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (value === null || value === undefined) return "–";
  return String(value);
}

/** Nested objects become "outer · inner"; whatever is called a warning or an error is marked. */
export function flatten(value: unknown, path: string[] = [], unit = "", alarming = false): SummaryLine[] {
  const label = path.join(" · ");
  if (Array.isArray(value)) {
    if (alarming || value.some((item) => typeof item === "object" && item !== null)) {
      const lines = value.slice(0, listed).flatMap((item, i) => {
        const name = path.slice(0, -1).concat(`${path[path.length - 1] ?? ""} ${value.length > 1 ? i + 1 : ""}`.trim());
        return flatten(item, name, unit, alarming);
      });
      if (value.length > listed) lines.push({ label, value: `${value.length - listed} more`, warning: alarming });
      return lines;
    }
    if (value.length === 0) return [];
    const more = value.length > listed ? `, … (${value.length} in all)` : "";
    const shown = value.slice(0, listed).map((item) => formatScalar(item, ""));
    return [{ label, value: shown.join(", ") + more + (unit ? ` ${unit}` : ""), warning: false }];
  }
  if (typeof value === "object" && value !== null) {
    // A run that did not end well: its status, and what is said about it.
    const failed = "status" in value && value.status !== "ok";
    return Object.entries(value).flatMap(([key, inner]) => {
      const split = splitKey(key);
      const alarm = /warning|error|problem/i.test(key) || (failed && /^(status|message)$/.test(key));
      return flatten(inner, [...path, split.label], split.unit, alarming || alarm);
    });
  }
  // A count of warnings that is zero, or an empty text, is good news.
  const warning = alarming && value !== 0 && value !== "" && value !== false && value !== null && typeof value !== "number";
  return [{ label, value: formatScalar(value, unit), warning }];
}
