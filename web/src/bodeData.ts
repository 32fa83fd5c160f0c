// Frequency responses, as mimbre writes them into the page (src/results/bode_report.cpp), and what the plots show of them.
import { f64, type PackedArray } from "./data";

export interface Named {
  name: string;
  unit: string;
}

interface Head {
  title: string;
  point: string;
  notes: string[];
  warnings: string[];
  inputs: Named[];
  outputs: Named[];
}

export interface PackedBode extends Head {
  format: string;
  frequencies: PackedArray;
  real: PackedArray;
  imaginary: PackedArray;
}

export interface Bode extends Head {
  frequencies: number[]; // Hz, ascending
  /** Of the first input all outputs, of each the values at all frequencies; then the second input. */
  real: Float64Array;
  imaginary: Float64Array;
}

export interface Response {
  real: Float64Array;
  imaginary: Float64Array;
}

export const bodeFormat = "mimbre-bode-1";

export function decodeBode(packed: PackedBode): Bode {
  if (packed.format !== bodeFormat) throw new Error(`unknown report format ${packed.format}`);
  return { ...packed, frequencies: [...f64(packed.frequencies)], real: f64(packed.real), imaginary: f64(packed.imaginary) };
}

export function responseOf({ frequencies, outputs, real, imaginary }: Bode, input: number, output: number): Response {
  const first = (input * outputs.length + output) * frequencies.length;
  const part = (values: Float64Array) => values.subarray(first, first + frequencies.length);
  return { real: part(real), imaginary: part(imaginary) };
}

export const magnitudes = ({ real, imaginary }: Response): number[] => Array.from(real, (value, k) => Math.hypot(value, imaginary[k]));

/** 20 log10; null where the response is nothing. */
export const decibels = (values: number[]): (number | null)[] => values.map((value) => (value > 0 ? 20 * Math.log10(value) : null));

/**
 * Degrees, continued over ±180°: the step between two frequencies is the shorter way. Null where the response is nothing or
 * not finite; it goes on behind. The whole is moved by turns so that its first value is within (−180°, 180°].
 */
export function phases({ real, imaginary }: Response): (number | null)[] {
  let before: number | null = null;
  return Array.from(real, (value, k) => {
    if (!Number.isFinite(value) || !Number.isFinite(imaginary[k]) || Math.hypot(value, imaginary[k]) === 0) return null;
    // atan2(−0, −1) is −180°.
    let angle = (Math.atan2(imaginary[k] === 0 ? 0 : imaginary[k], value) * 180) / Math.PI;
    if (before !== null) angle -= 360 * Math.round((angle - before) / 360);
    before = angle;
    return angle;
  });
}

/** Of a response: "m/N", "1/s", "no unit". */
export function ratioUnit(output: string, input: string): string {
  const plain = (unit: string) => (unit === "" ? "1" : unit);
  const [over, under] = [plain(output), plain(input)];
  if (over === under) return "no unit";
  if (under === "1") return over;
  return `${over}/${/[ /·*]/.test(under) ? `(${under})` : under}`;
}

/** Marks of an axis of phases: steps of 1°, 2°, 5°, 15°, 45°, 90° or whole multiples of 180°. */
export function phaseTicks(low: number, high: number, most = 7): number[] {
  const steps = [1, 2, 5, 15, 45, 90, 180, 360, 720, 1440, 3600, 7200, 36000];
  const step = steps.find((size) => (high - low) / size <= most) ?? steps[steps.length - 1];
  const ticks: number[] = [];
  for (let tick = Math.ceil(low / step - 1e-9) * step; tick <= high + 1e-9; tick += step) ticks.push(tick);
  return ticks;
}

const responds = (bode: Bode, input: number, output: number) => magnitudes(responseOf(bode, input, output)).some((value) => value > 0);

/** The first input to which an output responds. */
export function firstInput(bode: Bode): number {
  const found = bode.inputs.findIndex((_, input) => bode.outputs.some((__, output) => responds(bode, input, output)));
  return Math.max(found, 0);
}

/** What is plotted at first: outputs that respond, of one unit, few enough to be read. */
export function firstOutputs(bode: Bode, input: number, most = 4): number[] {
  const all = [...bode.outputs.keys()].filter((output) => responds(bode, input, output));
  return (all.length > 0 ? all : [...bode.outputs.keys()]).filter((output, _, [first]) => bode.outputs[output].unit === bode.outputs[first].unit).slice(0, most);
}
