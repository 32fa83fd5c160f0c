// The modes of a mechanism, as mimbre writes them into the page (src/results/mechanism_modes_report.cpp), and how they
// move its bodies.
import { Vector3 } from "three";
import { decodeScene, f32, type Animation, type Element, type PackedArray, type PackedScene, type Scene } from "./data";
import { Placement, posesAt, type Pose } from "./placement";

export interface MechanismMode {
  kind: "rigid" | "real" | "oscillating";
  frequency: number; // |λ|/2π, Hz
  damping: number; // ratio
  value: [real: number, imaginary: number]; // λ, 1/s
  grows: boolean;
  whirl: number;
  text: string;
  /** Largest displacement of a drawn point, m, and largest turn of a body, rad, of the shape as it is. */
  reach: number;
  turn: number;
  /** Im λ as seen from the ground, where that is known and the whole turns. */
  ground?: number;
}

interface Head {
  title: string;
  model: string;
  point: string;
  /** How many modes were found; the page may have fewer. */
  all: number;
  turning: number; // rad/s, of the whole mechanism; 0: it does not turn
  axis: number[]; // of that
  place: number[]; // a point of it, global
  period: number; // s, after which coefficients repeat; 0: they are constant
  size: number; // m, of the mechanism
  notes: string[];
  warnings: string[];
  modes: MechanismMode[];
}

export interface PackedMechanismModes extends PackedScene, Head {
  format: string;
  shapes: PackedArray;
  amplitudes: PackedArray;
}

export interface MechanismModes extends Head {
  /** At the point: an animation of one instant. */
  scene: Scene;
  /** Of each mode, of each body: displacement, real parts x y z, then imaginary ones; the same of its turn. */
  shapes: Float32Array;
  /** Of each mode all amplitudes: real parts, then imaginary ones. */
  amplitudes: Float32Array;
}

export const mechanismModesFormat = "mimbre-mechanism-modes-1";

export function decodeMechanismModes(packed: PackedMechanismModes): MechanismModes {
  if (packed.format !== mechanismModesFormat) throw new Error(`unknown report format ${packed.format}`);
  return { ...packed, scene: decodeScene(packed), shapes: f32(packed.shapes), amplitudes: f32(packed.amplitudes) };
}

/** By which a mode is drawn so that its largest displacement is a share of the size, and no body turns too far (drawing_factor of the library). */
export function drawingFactor({ reach, turn }: Pick<MechanismMode, "reach" | "turn">, size: number, share: number): number {
  const byReach = reach > 0 ? (share * (size || 1)) / reach : 0; // a single point is drawn as if it were 1 m large
  const byTurn = turn > 0 ? (share * 6) / turn : 0;
  return byReach > 0 && byTurn > 0 ? Math.min(byReach, byTurn) : Math.max(byReach, byTurn);
}

type Vector = [number, number, number];

const cross = (a: ArrayLike<number>, b: ArrayLike<number>): Vector => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** Where the screw of a displacement d and a turn t takes its origin: d + (1 − cos φ)/φ² t×d + (φ − sin φ)/φ³ t×(t×d), φ = |t|. */
export function screwed(d: Vector, t: Vector): Vector {
  const square = t[0] * t[0] + t[1] * t[1] + t[2] * t[2];
  const angle = Math.sqrt(square);
  const small = angle < 1e-2;
  const a = small ? 1 / 2 - square / 24 : (1 - Math.cos(angle)) / square;
  const b = small ? 1 / 6 - square / 120 : (angle - Math.sin(angle)) / (square * angle);
  const once = cross(t, d);
  const twice = cross(t, once);
  return [0, 1, 2].map((k) => d[k] + a * once[k] + b * twice[k]) as Vector;
}

/** The quaternion w x y z of a rotation vector. */
export function quaternionOf(t: Vector): [number, number, number, number] {
  const angle = Math.hypot(...t);
  const part = angle < 1e-8 ? 0.5 : Math.sin(angle / 2) / angle;
  return [Math.cos(angle / 2), part * t[0], part * t[1], part * t[2]];
}

/** The product of two quaternions w x y z. */
export function multiplied(p: ArrayLike<number>, q: ArrayLike<number>): [number, number, number, number] {
  return [
    p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
    p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
    p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
    p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
  ];
}

/** A point turned by a quaternion about a place. */
function turnedAbout(place: ArrayLike<number>, q: ArrayLike<number>, point: Vector): Vector {
  const from: Vector = [point[0] - place[0], point[1] - place[1], point[2] - place[2]];
  const v = [q[1], q[2], q[3]];
  const once = cross(v, from);
  const twice = cross(v, once);
  return [0, 1, 2].map((k) => place[k] + from[k] + 2 * (q[0] * once[k] + twice[k])) as Vector;
}

/**
 * Writes into a frame of `to` the mechanism moved by factor · Re(x e^{iφ}) of a mode x: bodies along the screws of their
 * displacements and turns, so that they stay rigid and turn about their hinges.
 */
export function moveByMode(report: MechanismModes, mode: number, factor: number, phase: number, to: Animation, frame: number): void {
  const { animation } = report.scene;
  const { bodies, amplitudes } = animation;
  const [c, s] = [factor * Math.cos(phase), factor * Math.sin(phase)];
  for (let body = 0; body < bodies; ++body) {
    const x = report.shapes.subarray(12 * (mode * bodies + body), 12 * (mode * bodies + body + 1));
    const at = (first: number): Vector => [0, 1, 2].map((k) => c * x[first + k] - s * x[first + 3 + k]) as Vector;
    const turn = at(6);
    const moved = screwed(at(0), turn);
    to.positions.set([0, 1, 2].map((k) => animation.positions[3 * body + k] + moved[k]), 3 * (frame * bodies + body));
    to.rotations.set(multiplied(quaternionOf(turn), animation.rotations.subarray(4 * body, 4 * body + 4)), 4 * (frame * bodies + body));
  }
  const real = 2 * mode * amplitudes;
  for (let k = 0; k < amplitudes; ++k)
    to.modes[frame * amplitudes + k] = animation.modes[k] + c * report.amplitudes[real + k] - s * report.amplitudes[real + amplitudes + k];
}

/** Turns the first instant of `to` by an angle about the axis of the whole, rad. */
export function turnWhole(report: MechanismModes, spin: number, to: Animation): void {
  const whole = quaternionOf(report.axis.map((value) => spin * value) as Vector);
  for (let body = 0; body < to.bodies; ++body) {
    const [position, rotation] = [to.positions.subarray(3 * body, 3 * body + 3), to.rotations.subarray(4 * body, 4 * body + 4)];
    position.set(turnedAbout(report.place, whole, [position[0], position[1], position[2]]));
    rotation.set(multiplied(whole, [...rotation]));
  }
}

const mostInLoops = 300; // bodies

/** Joints of the first instant of an animation that stay closed however far the mode goes. */
export class ClosedJoints {
  private placement: Placement;
  private rest: Map<Element, Pose> | null = null;

  constructor({ scene }: MechanismModes) {
    const { bodies, frames, elements, animation } = scene;
    this.placement = new Placement(bodies, frames, elements);
    const poses = posesAt(animation, 0, new Vector3());
    // Loops of many bodies would take too long for each picture.
    const many = bodies.length > mostInLoops && this.placement.hasLoops;
    if (!many && !poses.includes(null)) this.rest = this.placement.across(poses as Pose[], this.amplitudes(scene, animation));
  }

  close(scene: Scene): void {
    const { animation } = scene;
    const poses = posesAt(animation, animation.time[0], new Vector3());
    if (!this.rest || poses.includes(null)) return;
    const placed = this.placement.close(poses as Pose[], this.amplitudes(scene, animation), this.rest);
    if (!placed.every(({ position, rotation }) => [...position.toArray(), ...rotation.toArray()].every(Number.isFinite))) return;
    placed.forEach(({ position, rotation: { w, x, y, z } }, body) => {
      animation.positions.set(position.toArray(), 3 * body);
      animation.rotations.set([w, x, y, z], 4 * body);
    });
  }

  private amplitudes({ bodies }: Scene, { modes }: Animation): Float32Array[] {
    return bodies.map((body) => modes.subarray(body.firstMode, body.firstMode + body.modes));
  }
}

/** The first mode in which a body is deformed, else the first. */
export function bendingMode({ modes, amplitudes, scene }: MechanismModes): number {
  const each = 2 * scene.animation.amplitudes;
  return Math.max(modes.findIndex((_, mode) => amplitudes.subarray(mode * each, (mode + 1) * each).some((value) => Math.abs(value) > 1e-9)), 0);
}

const frames = 32; // of a period

/** A scene whose first instant is filled again and again, with a period after it, from 0 to 1, by which the view finds its bounds. */
export function movingScene(report: MechanismModes): Scene {
  const { animation, ...rest } = report.scene;
  const repeated = <T extends Float32Array | Float64Array>(values: T): T => {
    const all = new (values.constructor as new (size: number) => T)((frames + 1) * values.length);
    for (let frame = 0; frame <= frames; ++frame) all.set(values, frame * values.length);
    return all;
  };
  return {
    ...rest,
    animation: {
      ...animation,
      time: Float64Array.from({ length: frames + 1 }, (_, k) => k / frames),
      positions: repeated(animation.positions),
      rotations: repeated(animation.rotations),
      modes: repeated(animation.modes),
    },
  };
}

/** All instants but the first. */
export function fillPeriod(report: MechanismModes, mode: number, factor: number, to: Animation): void {
  for (let frame = 1; frame <= frames; ++frame) moveByMode(report, mode, factor, (2 * Math.PI * frame) / frames, to, frame);
}

/** Of the phase and of the spin, rad per second of the animation, so that the faster one goes round `turns` times a second. */
export function pace(mode: Pick<MechanismMode, "kind" | "value">, turning: number, turns: number): { phase: number; spin: number } {
  const oscillates = mode.kind === "oscillating";
  const own = oscillates ? Math.abs(mode.value[1]) : turning > 0 ? turning : 1;
  const fastest = Math.max(own, turning);
  const scale = (2 * Math.PI * turns) / fastest;
  return { phase: scale * own, spin: scale * turning };
}

/** What is wrong with the modes, and what is to be known about them. */
export function remarks(report: MechanismModes): string[] {
  const more = report.notes.map((text) => text.charAt(0).toUpperCase() + text.slice(1));
  if (report.modes.length < report.all) more.push(`This page has the first ${report.modes.length} of ${report.all} modes.`);
  if (report.period > 0) more.push("The shapes are those at the point; they change over the period.");
  return more;
}
