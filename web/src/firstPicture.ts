// What a page opens on: the instant at which most happens, and how much larger than they are deformations are drawn.
import type { Animation } from "./data";
import type { Peak } from "./coloring";

const ofBody = 0.08; // the largest deflection as it is drawn, in lengths of its body
const ofMechanism = 0.05; // and in sizes of the mechanism
const visible = 1e-3; // sizes of the mechanism; smaller deflections are not seen
const leads = 0.25; // s on the screen before the instant

/** 1, 2 or 5 times a power of ten, not above `value`. */
function roundedDown(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const digit = [5, 2, 1].find((lead) => lead * power <= value * (1 + 1e-9)) ?? 1;
  return Number((digit * power).toPrecision(1));
}

/**
 * The factor by which deformations are drawn so that they are seen and no body is out of shape; 1 where they are seen
 * as they are, or not even with the largest factor. `deflections`: the largest of each flexible body, and its length.
 */
export function firstExaggeration(deflections: { value: number; length: number }[], size: number, largest: number): number {
  const moving = deflections.filter(({ value, length }) => value > 0 && length > 0);
  const most = Math.max(0, ...moving.map(({ value }) => value));
  if (!(most > 0)) return 1;
  const wanted = Math.min((ofMechanism * size) / most, ...moving.map(({ value, length }) => (ofBody * length) / value));
  if (wanted < 2) return 1;
  const factor = Math.min(roundedDown(wanted), largest);
  return factor * most < visible * size ? 1 : factor;
}

/** Largest speed of a body at each instant: of its origin against that of `reference` (−1: the ground), and by its turning at `radii`. */
function speeds({ time, positions, rotations, bodies }: Animation, radii: number[], reference: number): number[] {
  return Array.from(time, (_, i) => {
    const [a, b] = [Math.max(i - 1, 0), Math.min(i + 1, time.length - 1)];
    const dt = time[b] - time[a];
    if (!(dt > 0)) return 0;
    const moved = (body: number, axis: number) => positions[3 * (b * bodies + body) + axis] - positions[3 * (a * bodies + body) + axis];
    return radii.reduce((most, radius, body) => {
      const shift = [0, 1, 2].map((axis) => moved(body, axis) - (reference >= 0 ? moved(reference, axis) : 0));
      const cosine = [0, 1, 2, 3].reduce((sum, k) => sum + rotations[4 * (a * bodies + body) + k] * rotations[4 * (b * bodies + body) + k], 0);
      const turn = 2 * Math.acos(Math.min(Math.abs(cosine), 1));
      const speed = (Math.hypot(...shift) + radius * turn) / dt;
      return Number.isFinite(speed) ? Math.max(most, speed) : most;
    }, 0);
  });
}

/** Where flexible bodies deform most; without any, where the motion is fastest. `radii`: of the bodies as they are drawn. */
export function tellingInstant(animation: Animation, peaks: Peak[], radii: number[], reference = -1): number {
  const { time } = animation;
  const deformed = peaks.reduce((most, peak) => (peak.value > most.value ? peak : most), { value: 0, point: -1, time: 0 });
  if (deformed.value > 0) return deformed.time;
  const all = speeds(animation, radii, reference);
  const fastest = Math.max(0, ...all);
  // The first of those that are as fast: a steady motion opens where it begins.
  const at = all.findIndex((speed) => speed >= 0.98 * fastest);
  return time[Math.max(at, 0)] ?? 0;
}

/** From where the animation plays, so that the instant comes a moment later. */
export function playFrom(instant: number, start: number, speed: number): number {
  return Math.max(start, instant - leads * speed);
}
