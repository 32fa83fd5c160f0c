// The unit in which people read a quantity of some size: kN rather than 1e3 N, mm rather than 0.001 m, ° rather than rad.
import { formatNumber } from "./format";

export interface Scale {
  unit: string;
  /** Of one such unit in the channel's own. */
  size: number;
}

const prefixes: [name: string, size: number][] = [["p", 1e-12], ["n", 1e-9], ["µ", 1e-6], ["m", 1e-3], ["", 1], ["k", 1e3], ["M", 1e6], ["G", 1e9], ["T", 1e12]];

/** Prefixes that are in use with a unit; of others only the unit itself. */
const usual: Record<string, string[]> = {
  m: ["n", "µ", "m", "", "k"],
  s: ["n", "µ", "m", ""],
  "m/s": ["n", "µ", "m", ""],
  "m/s²": ["m", ""],
  N: ["n", "µ", "m", "", "k", "M"],
  "N m": ["n", "µ", "m", "", "k", "M"],
  "N/m": ["m", "", "k", "M"],
  J: ["p", "n", "µ", "m", "", "k", "M"],
  W: ["n", "µ", "m", "", "k", "M"],
  Pa: ["", "k", "M", "G", "T"],
  Hz: ["", "k", "M"],
};

/** Some metres more than a thousand are read as metres. */
const least = (unit: string, name: string) => (unit === "m" && name === "k" ? 10 : 1);

const angles: Record<string, string> = { rad: "°", "rad/s": "°/s", "rad/s²": "°/s²" };

/** The usual unit with the largest prefix in which `value` is at least 1, or the smallest. */
export function scaleFor(unit: string, value: number): Scale {
  if (angles[unit]) return { unit: angles[unit], size: Math.PI / 180 };
  const names = usual[unit];
  if (!names || !(Math.abs(value) > 0) || !Number.isFinite(value)) return { unit, size: 1 };
  const known = prefixes.filter(([name]) => names.includes(name));
  const fitting = known.filter(([name, size]) => Math.abs(value) >= 0.9999 * size * least(unit, name));
  // Round-off of a zero keeps the unit without prefix.
  const small = Math.abs(value) >= 1e-3 * known[0][1] ? known[0] : (["", 1] as const);
  const [name, size] = fitting[fitting.length - 1] ?? small;
  return { unit: name + unit, size };
}

/** Of a time, and of a frequency axis up to `value`: 0.5 s rather than 500 ms, 2500 Hz rather than 2.5 kHz. */
export function axisScale(unit: string, value: number): Scale {
  return scaleFor(unit, value * (unit === "s" ? 20 : unit === "Hz" ? 0.1 : 1));
}

/** Formats times between `start` and `end` with the decimals that distinguish `instants` of them at equal distances. */
export function timeText(start: number, end: number, instants: number): (time: number) => string {
  const { unit, size } = axisScale("s", Math.max(Math.abs(start), Math.abs(end)));
  const gap = (end - start) / Math.max(instants - 1, 1) / size;
  const decimals = gap > 0 ? Math.min(Math.max(Math.ceil(-Math.log10(gap) - 1e-6), unit === "s" ? 3 : 1), 9) : 3;
  return (time) => `${(time / size).toFixed(decimals)} ${unit}`;
}

/** Labels of an axis: as many decimals as tell them apart, all whole. */
export function tickLabels(values: number[]): string[] {
  const gap = values.length > 1 ? Math.abs(values[1] - values[0]) : Math.abs(values[0] ?? 0);
  const largest = Math.max(...values.map(Math.abs), 0);
  if (largest >= 1e7 || (largest > 0 && largest < 1e-4)) return values.map((value) => formatNumber(value, 3));
  let decimals = gap > 0 ? Math.min(Math.max(0, -Math.floor(Math.log10(gap) + 1e-6)), 10) : 0;
  // Steps of 0.25 need one more than steps of 0.2.
  const rest = (gap * 10 ** decimals) % 1;
  if (decimals < 10 && Math.min(rest, 1 - rest) > 0.01) ++decimals;
  return values.map((value) => {
    const [whole, fraction] = Math.abs(value).toFixed(decimals).split(".");
    const grouped = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, "\u202f") : whole;
    const negative = value < 0 && Number(value.toFixed(decimals)) !== 0;
    return (negative ? "−" : "") + grouped + (fraction ? `.${fraction}` : "");
  });
}

/** Marks of a logarithmic axis that have a label: powers of ten, with more between them where they are few, and not all where they are many. */
export function logarithmicTicks(low: number, high: number): number[] {
  const ticks: number[] = [];
  const decades = Math.log10(high / low);
  const factors = decades > 3 ? [1] : decades > 1.2 ? [1, 2, 5] : [1, 2, 3, 4, 5, 6, 7, 8, 9];
  const every = Math.max(1, Math.ceil(decades / 8));
  for (let power = every * Math.floor(Math.log10(low) / every); power <= Math.ceil(Math.log10(high)); power += every)
    for (const factor of factors) {
      const tick = Number(`${factor}e${power}`);
      if (tick >= low * (1 - 1e-9) && tick <= high * (1 + 1e-9)) ticks.push(tick);
    }
  return ticks;
}

/**
 * Which curves go to a second axis, so that small ones are seen beside large ones: where their ranges, in order of size,
 * leave the widest gap, if it is more than tenfold. A millionth of the largest is round-off and goes with the first.
 */
export function onSecondAxis(ranges: number[], gap = 10): boolean[] {
  const least = 1e-6 * Math.max(0, ...ranges);
  const sorted = [...new Set(ranges.filter((range) => range > least))].sort((a, b) => a - b);
  let limit = 0;
  let widest = gap;
  for (let k = 0; k + 1 < sorted.length; ++k) {
    const ratio = sorted[k + 1] / sorted[k];
    if (ratio > widest) [widest, limit] = [ratio, sorted[k]];
  }
  return ranges.map((range) => range > least && range <= limit);
}
