// The data that mimbre writes into the page (src/results/report*.cpp), and as the page uses them.

export interface PackedArray {
  type: "f32" | "f64" | "u32";
  size: number;
  data: string; // base64, little-endian
}

export interface PackedBody {
  name: string;
  modes: number;
  lineRadius: number;
  points: PackedArray;
  pointShapes: PackedArray;
  lines: PackedArray;
  triangles: PackedArray;
  edges: PackedArray;
  labels: PackedArray;
  stress: PackedArray;
  barStress: PackedArray;
  roundLines: PackedArray;
  shapes: Solid[];
}

interface PackedFrame {
  name: string;
  body: number;
  position: number[];
  rotation: number[];
  motion: PackedArray;
}

/** What is animated. Results of earlier versions have no frames and elements. */
export interface PackedScene {
  bodies: PackedBody[];
  roads: (Omit<Road, "profile"> & { profile: PackedArray })[];
  frames?: PackedFrame[];
  elements?: PackedElement[];
  animation: { time: PackedArray; positions: PackedArray; rotations: PackedArray; modes: PackedArray };
}

export interface PackedReport extends PackedScene {
  format: string;
  title: string;
  step: number;
  instants: number;
  model: string;
  options: unknown;
  summary: unknown;
  time: PackedArray;
  channels: { name: string; unit: string; meaning: string; offset: number }[];
  values: PackedArray;
  shown: number[];
}

/** A solid drawn on a body, in body axes. Sizes: box edges; cylinder (axis z) radius, length; sphere radius. */
export interface Solid {
  kind: "box" | "cylinder" | "sphere";
  size: number[];
  position: number[];
  rotation: number[]; // row-major
}

/** A point with axes where joints and forces act. */
export interface Frame {
  name: string;
  /** −1: the ground. */
  body: number;
  position: number[]; // undeformed, body axes; of the ground global
  rotation: number[]; // row-major
  /** Per mode of the body: displacement x y z and small turn x y z in body axes per unit amplitude. */
  motion: Float32Array;
}

/** A joint (kind: its type), "spring", "damper", "spring damper", "actuator", of a joint's own "torsional …" with "about z" or "sliding …" with "along z", "load", "tyre", "tyre on rig", of a constraint "distance", "on_line", "on_plane", "on_curve", "parallel", "perpendicular", "constant_velocity", "screw"; "coupling" or "coupling spring" between joints; on a joint "motor", "friction", "stop" with "about z" or "along z"; "bushing"; "drag". */
export interface Element {
  name: string;
  kind: string;
  a: number; // frames; −1: none
  b: number;
  size: number; // a tyre's radius
  /** Of "on_curve": x y z per point, in the axes of frame a. */
  curve?: Float32Array;
}

export type PackedElement = Omit<Element, "curve"> & { curve?: PackedArray };

/** Values over time, found by the name of a channel; null where there is none. */
export type Signals = (channel: string) => { time: ArrayLike<number>; values: ArrayLike<number | null> } | null;

export interface Body {
  name: string;
  /** Of this body's first amplitude among those of all bodies. */
  firstMode: number;
  modes: number;
  lineRadius: number;
  points: Float32Array; // x y z per point, body axes
  /** Per mode, x y z per point; empty for a rigid body. */
  pointShapes: Float32Array;
  lines: Uint32Array; // two points per line; not those of the surface
  triangles: Uint32Array; // three points each: the surface
  edges: Uint32Array; // two points each: the lines worth drawing on the surface
  labels: Float64Array; // of the points in their mesh; empty: unknown
  /** Per mode, of each point xx yy zz xy yz zx, Pa at unit amplitude; of the first modes, or empty. */
  stress: Float32Array;
  /** Of bars, per mode at the start and the end of each line: largest normal stress by N, My, Mz, and √3 times the shear stress by T, Pa at unit amplitude; of the first modes, or empty. */
  barStress: Float32Array;
  roundLines: Uint32Array; // whose outermost fibres are a circle; else the corners of a rectangle
  shapes: Solid[];
}

/** What a channel is called, for the list of channels. */
export interface ChannelName {
  name: string;
  unit: string;
  meaning: string;
}

/** Values: one per instant of Report.time. */
export interface Channel extends ChannelName, Curve {}

export interface Animation {
  time: Float64Array;
  positions: Float64Array; // instants × bodies × 3, global
  rotations: Float32Array; // instants × bodies × 4: w x y z
  modes: Float32Array; // instants × amplitudes of all bodies
  bodies: number;
  amplitudes: number;
}

export interface Road {
  name: string;
  profile: Float64Array; // x, z, x, z, …
  /** Where tyres find another grip; of live scenes. */
  patches?: Patch[];
}

/** Between two places along and across; `friction`: factor on that of the tyres. */
export interface Patch {
  x: [from: number, to: number];
  y: [from: number, to: number];
  friction: number;
}

export interface Scene {
  bodies: Body[];
  roads: Road[];
  frames: Frame[];
  elements: Element[];
  animation: Animation;
  /** Where the forces that are drawn come from; without, none are. */
  signals?: Signals;
}

export interface Report extends Scene {
  title: string;
  step: number;
  instants: number;
  model: string;
  options: unknown;
  summary: unknown;
  time: number[];
  channels: Channel[];
  shown: number[];
}

/** Throws where the data do not have the stated size. */
export function decodeArray(packed: PackedArray): Float32Array | Float64Array | Uint32Array {
  const text = atob(packed.data);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  const type = { f32: Float32Array, f64: Float64Array, u32: Uint32Array }[packed.type];
  if (!type || bytes.length !== packed.size * type.BYTES_PER_ELEMENT)
    throw new Error(`damaged array: ${bytes.length} bytes for ${packed.size} ${packed.type}`);
  return new type(bytes.buffer);
}

export const f32 = (packed: PackedArray) => decodeArray(packed) as Float32Array;
export const f64 = (packed: PackedArray) => decodeArray(packed) as Float64Array;
const u32 = (packed: PackedArray) => decodeArray(packed) as Uint32Array;

export interface Curve {
  /** null where the value is not finite */
  values: (number | null)[];
  /** Largest less smallest finite value. */
  range: number;
}

/** Of single-precision values without their offset. */
export function decodeCurve(own: Float32Array, offset: number): Curve {
  let low = Infinity;
  let high = -Infinity;
  for (const value of own) {
    if (!Number.isFinite(value)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  const values = Array.from(own, (value) => (Number.isFinite(value) ? value + offset : null));
  return { values, range: Math.max(high - low, 0) };
}

export function decodeReport(packed: PackedReport): Report {
  if (packed.format !== "mimbre-report-1") throw new Error(`unknown report format ${packed.format}`);
  const time = Array.from(f64(packed.time));
  const values = f32(packed.values);
  const channels = packed.channels.map(({ name, unit, meaning, offset }, k) => {
    const own = values.subarray(k * time.length, (k + 1) * time.length);
    // Of hundreds of channels few are looked at.
    let known: Curve | null = null;
    const curve = () => (known ??= decodeCurve(own, offset));
    return {
      name,
      unit,
      meaning,
      get values() {
        return curve().values;
      },
      get range() {
        return curve().range;
      },
    };
  });
  const byName = new Map(channels.map((channel) => [channel.name, channel]));
  const signals: Signals = (name) => {
    const channel = byName.get(name);
    return channel ? { time, values: channel.values } : null;
  };
  return {
    title: packed.title,
    step: packed.step,
    instants: packed.instants,
    model: packed.model,
    options: packed.options,
    summary: packed.summary,
    time,
    channels,
    shown: packed.shown,
    ...decodeScene(packed),
    signals,
  };
}

export function decodeBody(body: PackedBody, firstMode = 0): Body {
  return {
    name: body.name,
    firstMode,
    modes: body.modes,
    lineRadius: body.lineRadius,
    points: f32(body.points),
    pointShapes: f32(body.pointShapes),
    lines: u32(body.lines),
    triangles: u32(body.triangles),
    edges: u32(body.edges),
    labels: f64(body.labels),
    stress: f32(body.stress),
    barStress: f32(body.barStress),
    roundLines: u32(body.roundLines),
    shapes: body.shapes,
  };
}

export function decodeScene(packed: PackedScene): Scene {
  let firstMode = 0;
  const bodies = packed.bodies.map((body) => {
    const decoded = decodeBody(body, firstMode);
    firstMode += body.modes;
    return decoded;
  });
  return {
    bodies,
    roads: packed.roads.map(({ profile, ...road }) => ({ ...road, profile: f64(profile) })),
    frames: (packed.frames ?? []).map((frame) => ({ ...frame, motion: f32(frame.motion) })),
    elements: (packed.elements ?? []).map(({ curve, ...element }) => (curve ? { ...element, curve: f32(curve) } : element)),
    animation: {
      time: f64(packed.animation.time),
      positions: f64(packed.animation.positions),
      rotations: f32(packed.animation.rotations),
      modes: f32(packed.animation.modes),
      bodies: bodies.length,
      amplitudes: firstMode,
    },
  };
}
