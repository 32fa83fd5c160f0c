// Several runs, as mimbre writes them into the page (src/results/comparison_report.cpp), and as the page uses them.
import { decodeCurve, decodeScene, f32, f64, type ChannelName, type Curve, type PackedArray, type PackedScene, type Scene, type Signals } from "./data";

interface RunHead {
  label: string;
  file: string;
  title: string;
  step: number;
  instants: number;
  model: string;
  options: unknown;
  summary: unknown;
}

interface PackedRun extends RunHead {
  time: PackedArray;
  /** Of the channels that the run has, in their order. */
  values: PackedArray;
  /** Instants on which the run is compared with the first. */
  commonTime: PackedArray;
  /** Of the channels that have a deviation of this run, in their order. */
  differences: PackedArray;
}

/** null where it is not finite */
export interface Deviation {
  mean: number | null;
  largest: number | null;
  /** Time of the largest. */
  at: number;
  /** Largest absolute value of the first run. */
  amplitude: number | null;
}

export interface PackedComparison extends PackedScene {
  format: string;
  /** Of the second run and those after it; a part that is as the first run's is left out. */
  ghosts?: (Partial<PackedScene> & Pick<PackedScene, "animation">)[];
  runs: PackedRun[];
  channels: (ChannelName & { curves: { run: number; offset: number }[]; deviations: ({ run: number; offset: number } & Deviation)[] })[];
  shown: number[];
}

export interface Run extends RunHead {
  time: number[];
  commonTime: number[];
}

export interface ComparedChannel extends ChannelName {
  /** One per run, null for a run without the channel; values at the run's times. */
  curves: (Curve | null)[];
  /** The run less the first, at the run's common times; null for the first, and where there is nothing to compare. */
  differences: (Curve | null)[];
  deviations: (Deviation | null)[];
}

export interface Comparison extends Scene {
  runs: Run[];
  channels: ComparedChannel[];
  shown: number[];
  /** The second run and those after it. */
  ghosts: Scene[];
}

export const comparisonFormat = "mimbre-comparison-1";

/** Hands out the curves of one run, one after another. */
function curveReader(values: Float32Array, length: number): (offset: number) => Curve {
  let at = 0;
  return (offset) => decodeCurve(values.subarray(at, (at += length)), offset);
}

export function decodeComparison(packed: PackedComparison): Comparison {
  if (packed.format !== comparisonFormat) throw new Error(`unknown report format ${packed.format}`);
  const runs = packed.runs.map((run) => ({ ...run, time: Array.from(f64(run.time)), commonTime: Array.from(f64(run.commonTime)) }));
  const nextCurve = packed.runs.map((run, r) => curveReader(f32(run.values), runs[r].time.length));
  const nextDifference = packed.runs.map((run, r) => curveReader(f32(run.differences), runs[r].commonTime.length));
  const channels = packed.channels.map(({ name, unit, meaning, ...packedChannel }) => {
    const none = <T>() => runs.map((): T | null => null);
    const channel: ComparedChannel = { name, unit, meaning, curves: none(), differences: none(), deviations: none() };
    for (const { run, offset } of packedChannel.curves) channel.curves[run] = nextCurve[run](offset);
    for (const { run, offset, ...deviation } of packedChannel.deviations) {
      channel.differences[run] = nextDifference[run](offset);
      channel.deviations[run] = deviation;
    }
    return channel;
  });
  const signals: Signals = (name) => {
    const curve = channels.find((channel) => channel.name === name)?.curves[0];
    return curve ? { time: runs[0].time, values: curve.values } : null;
  };
  const { bodies, frames, elements } = packed;
  const ghosts = (packed.ghosts ?? []).map((ghost) => decodeScene({ bodies, frames, elements, roads: [], ...ghost }));
  return { runs, channels, shown: packed.shown, ghosts, ...decodeScene(packed), signals };
}
