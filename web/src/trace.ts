// Curves as the views of the channels draw them, whether of one run or of several.
import type { ChannelName, Curve } from "./data";

export interface Trace extends ChannelName, Curve {
  channel: number;
  run: number;
  /** In the legend: the channel, and of several runs the run. */
  label: string;
  color: string;
  time: number[];
}

export interface Curves {
  channels: ChannelName[];
  /** In the order of the selection, runs that are hidden left out. */
  traces(selection: number[]): Trace[];
}

export interface Range {
  min: number;
  max: number;
}

/** Units in the order of their first curve. */
export function byUnit(traces: Trace[]): Map<string, Trace[]> {
  const units = new Map<string, Trace[]>();
  for (const trace of traces) units.set(trace.unit, [...(units.get(trace.unit) ?? []), trace]);
  return units;
}

/** The largest magnitude among the finite values. */
export function largest(values: ArrayLike<number | null>): number {
  let most = 0;
  for (let i = 0; i < values.length; ++i) most = Math.max(most, Math.abs(values[i] ?? 0));
  return most;
}

/** The same of those in [from, to] alone. */
export function magnitude(trace: { time: ArrayLike<number>; values: ArrayLike<number | null> }, from: number, to: number): number {
  let most = 0;
  for (let i = 0; i < trace.values.length; ++i) if (trace.time[i] >= from && trace.time[i] <= to) most = Math.max(most, Math.abs(trace.values[i] ?? 0));
  return most;
}

export const scaled = (values: (number | null)[], size: number) => (size === 1 ? values : values.map((value) => (value === null ? null : value / size)));
