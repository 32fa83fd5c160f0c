// Messages to and from the live server (docs/live-protocol.md), and their form in the page.
import { decodeScene, type ChannelName, type PackedScene, type Scene } from "./data";

export const protocol = "mimbre-live-1";

/** What can be changed while the simulation runs. */
export interface Input {
  name: string;
  unit: string;
  /** Absent: there is no bound. */
  min?: number;
  max?: number;
  start: number;
  value: number;
  /** A parameter of the model, rather than something that is driven. */
  tunable: boolean;
  about?: string;
}

export interface PackedLiveScene extends PackedScene {
  format: string;
  title: string;
  step: number;
  speed: number;
  model: string;
  channels: ChannelName[];
  outputs: number;
  shown: number[];
  inputs: Input[];
  policy: string;
  recording: boolean;
  record?: string;
}

export interface LiveScene extends Omit<PackedLiveScene, keyof PackedScene> {
  scene: Scene;
}

export function decodeLiveScene(packed: PackedLiveScene): LiveScene {
  if (packed.format !== protocol) throw new Error(`the server uses protocol ${packed.format}, this page ${protocol}`);
  const { bodies, roads, frames, elements, animation, ...rest } = packed;
  return { ...rest, scene: decodeScene({ bodies, roads, frames, elements, animation }) };
}

/** What must be the same for the page to go on with another run of the server. */
export function sameModel(a: PackedLiveScene, b: PackedLiveScene): boolean {
  const facts = ({ format, title, step, model, bodies, channels, inputs }: PackedLiveScene) =>
    JSON.stringify([format, title, step, model, bodies, channels, inputs.map(({ name, unit, min, max, tunable }) => [name, unit, min, max, tunable])]);
  return facts(a) === facts(b);
}

/** Of some times, s. */
export interface Spread {
  median: number;
  p99: number;
  p9999: number;
  worst: number;
}

export type RunState = "running" | "paused" | "ended" | "failed";

export interface Status {
  time: number;
  steps: number;
  state: RunState;
  message: string;
  step: number;
  speed: number;
  viewers: number;
  recording: boolean;
  clock: { scheduling: string; memory: string; cpu: string };
  computation: Spread;
  cpu: Spread;
  latency: Spread;
  overruns: Record<string, number>;
  histogram: { edges: number[]; computation: number[]; latency: number[] };
  iterations: { mean: number; most: number };
  /** Why recording does not work. */
  record_failure?: string;
  worst_case: string;
}

/** Over what times an input goes from value to value. */
export interface Track {
  times: number[];
  values: number[];
}

export type Said =
  | { say: "hello"; viewer: number; control: boolean; channels: number[] }
  | ({ say: "status" } & Status)
  | { say: "control"; yours: boolean; taken: boolean }
  | { say: "asked"; viewer: number }
  | { say: "channels"; indices: number[]; choice: number }
  | { say: "snapshots"; names: string[] }
  | { say: "recording"; on: boolean; file?: string }
  | { say: "played"; on: boolean }
  | { say: "error"; message: string };

export type Order =
  | { do: "channels"; indices: number[] }
  | { do: "control"; take: boolean }
  | { do: "inputs"; values: Record<string, number> }
  | { do: "pause" | "resume" | "step" | "reset" }
  | { do: "snapshot" | "restore"; name: string }
  | { do: "record"; on: boolean }
  | { do: "play"; tracks?: Record<string, Track> };

export const mostChannels = 64; // that a viewer may choose
export const longestOrder = 8 * 1024 * 1024; // bytes, of the viewer in control

/** One instant of the simulation. */
export interface Picture {
  paused: boolean;
  recording: boolean;
  failed: boolean;
  ended: boolean;
  played: boolean;
  control: boolean;
  time: number; // of the simulation, s
  clock: number; // of the server, s
  steps: number;
  deadline: number; // the last step's computation over its length
  choice: number;
  positions: Float64Array;
  rotations: Float32Array;
  amplitudes: Float32Array;
  channels: Float32Array;
  inputs: Float32Array;
}

const headLength = 40; // bytes

/** Throws where the message does not have the stated length. */
export function decodePicture(message: ArrayBuffer, bodies: number, amplitudes: number): Picture {
  if (message.byteLength < headLength) throw new Error(`a picture of ${message.byteLength} bytes`);
  const head = new DataView(message);
  const kind = head.getUint8(0);
  if (kind !== 1) throw new Error(`a message of the unknown kind ${kind}`);
  const bits = head.getUint8(1);
  const channels = head.getUint16(2, true);
  const inputs = head.getUint32(4, true);
  const expected = headLength + 24 * bodies + 16 * bodies + 4 * (amplitudes + channels + inputs);
  if (message.byteLength !== expected) throw new Error(`a picture of ${message.byteLength} bytes instead of ${expected}`);
  let at = headLength;
  const floats = (count: number) => {
    const array = new Float32Array(message, at, count);
    at += 4 * count;
    return array;
  };
  const positions = new Float64Array(message, at, 3 * bodies);
  at += 24 * bodies;
  return {
    paused: (bits & 1) !== 0,
    recording: (bits & 2) !== 0,
    failed: (bits & 4) !== 0,
    ended: (bits & 8) !== 0,
    played: (bits & 16) !== 0,
    control: (bits & 32) !== 0,
    time: head.getFloat64(8, true),
    clock: head.getFloat64(16, true),
    steps: Number(head.getBigUint64(24, true)),
    deadline: head.getFloat32(32, true),
    choice: head.getUint32(36, true),
    positions,
    rotations: floats(4 * bodies),
    amplitudes: floats(amplitudes),
    channels: floats(channels),
    inputs: floats(inputs),
  };
}
