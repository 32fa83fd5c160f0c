// A reduced body, as mimbre writes it into the page (src/results/modes_report.cpp), and as the page uses it.
import { decodeBody, f32, type Body, type PackedArray, type PackedBody, type Scene } from "./data";

export interface Check {
  name: string;
  passed: boolean;
  detail: string;
}

interface Mode {
  name: string;
  frequency: number | null; // Hz; null: none is known
}

interface FrameHead {
  name: string;
  position: number[];
  rotation: number[]; // row-major, frame axes to body axes
}

export interface PackedModes {
  format: string;
  name: string;
  checks: Check[];
  mass: number;
  centre: (number | null)[];
  inertia: (number | null)[];
  frames: (FrameHead & { shapes: PackedArray; turns: PackedArray })[];
  families: { name: string; modes: Mode[]; amplitudes: PackedArray }[];
  body: PackedBody;
}

/** Moves by `shapes`, turns by `turns`, per mode x y z in body axes. */
export interface Frame extends FrameHead {
  shapes: Float32Array;
  turns: Float32Array;
}

/** A set of modes; amplitudes: per mode those of the body. */
export interface Family {
  name: string;
  modes: Mode[];
  amplitudes: Float32Array;
}

export interface ModesReport {
  name: string;
  checks: Check[];
  mass: number;
  centre: (number | null)[];
  inertia: (number | null)[];
  frames: Frame[];
  families: Family[];
  body: Body;
}

export const modesFormat = "mimbre-modes-1";

export function decodeModes(packed: PackedModes): ModesReport {
  if (packed.format !== modesFormat) throw new Error(`unknown report format ${packed.format}`);
  return {
    name: packed.name,
    checks: packed.checks,
    mass: packed.mass,
    centre: packed.centre,
    inertia: packed.inertia,
    frames: packed.frames.map((frame) => ({ ...frame, shapes: f32(frame.shapes), turns: f32(frame.turns) })),
    families: packed.families.map((family) => ({ ...family, amplitudes: f32(family.amplitudes) })),
    body: decodeBody(packed.body),
  };
}

/** The body's amplitudes at amplitude 1 of a mode. */
export function amplitudesOf(report: ModesReport, family: number, mode: number): Float32Array {
  const count = report.body.modes;
  return report.families[family].amplitudes.subarray(mode * count, (mode + 1) * count);
}

/** The body alone; its time runs from −1 to 1, and the amplitudes with it from −amplitudes to amplitudes. */
export function swingScene(body: Body, amplitudes: Float32Array): Scene {
  return {
    bodies: [body],
    roads: [],
    frames: [],
    elements: [],
    animation: {
      time: new Float64Array([-1, 1]),
      positions: new Float64Array(6),
      rotations: new Float32Array([1, 0, 0, 0, 1, 0, 0, 0]),
      modes: swing(amplitudes),
      bodies: 1,
      amplitudes: body.modes,
    },
  };
}

export function swing(amplitudes: Float32Array): Float32Array {
  return Float32Array.from([...amplitudes.map((value) => -value), ...amplitudes]);
}

/** The result of the checks in one sentence. */
export function verdict(checks: Check[]): { text: string; passed: boolean } {
  if (checks.length === 0) return { text: "Not validated: the body's file contains no checks.", passed: false };
  const failed = checks.filter((check) => !check.passed);
  if (failed.length === 0) return { text: `All ${checks.length} checks of the reduction passed.`, passed: true };
  const names = failed.map(({ name }) => name).join(", ");
  return { text: `${failed.length} of ${checks.length} checks of the reduction failed: ${names}.`, passed: false };
}

/** The failed ones first. */
export function ordered(checks: Check[]): Check[] {
  return [...checks.filter((check) => !check.passed), ...checks.filter((check) => check.passed)];
}

/** Σ amplitude·column, columns of three. */
export function combined(columns: Float32Array, amplitudes: ArrayLike<number>): [number, number, number] {
  const sum: [number, number, number] = [0, 0, 0];
  for (let mode = 0; 3 * mode < columns.length; ++mode)
    for (let k = 0; k < 3; ++k) sum[k] += amplitudes[mode] * columns[3 * mode + k];
  return sum;
}
