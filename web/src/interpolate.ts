// Poses and modal amplitudes between the instants of the animation.
import type { Animation } from "./data";

/** Between which instants `t` lies: the earlier one and the fraction of the way to the next; clamped to the ends. */
export function locate(time: ArrayLike<number>, t: number): { index: number; fraction: number } {
  const last = time.length - 1;
  if (last < 1 || t <= time[0]) return { index: 0, fraction: 0 };
  if (t >= time[last]) return { index: last - 1, fraction: 1 };
  let low = 0;
  let high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (time[middle] <= t) low = middle;
    else high = middle;
  }
  const length = time[high] - time[low];
  return { index: low, fraction: length > 0 ? (t - time[low]) / length : 0 };
}

/** The instant nearest to `t`. */
export function nearest(time: ArrayLike<number>, t: number): number {
  const { index, fraction } = locate(time, t);
  return fraction < 0.5 ? index : index + 1;
}

export type Quaternion = [w: number, x: number, y: number, z: number];

/** Along the shorter great circle from a to b, both unit quaternions (w x y z). */
export function slerp(a: Quaternion, b: Quaternion, fraction: number): Quaternion {
  let cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const sign = cosine < 0 ? -1 : 1;
  cosine *= sign;
  let p = 1 - fraction;
  let q = fraction;
  // Nearly equal: the chord is the arc to double precision, and the sine would be zero.
  if (cosine < 1 - 1e-9) {
    const angle = Math.acos(cosine);
    p = Math.sin(p * angle) / Math.sin(angle);
    q = Math.sin(q * angle) / Math.sin(angle);
  }
  q *= sign;
  const mixed: Quaternion = [
    p * a[0] + q * b[0],
    p * a[1] + q * b[1],
    p * a[2] + q * b[2],
    p * a[3] + q * b[3],
  ];
  const norm = Math.hypot(...mixed) || 1;
  return [mixed[0] / norm, mixed[1] / norm, mixed[2] / norm, mixed[3] / norm];
}

/** The later instant; at an instant itself that one, so that a broken one after it does no harm. */
function following(index: number, fraction: number): number {
  return fraction > 0 ? index + 1 : index;
}

export interface BodyPose {
  position: [number, number, number];
  rotation: Quaternion;
}

function quaternionAt(animation: Animation, index: number, body: number): Quaternion {
  const at = 4 * (index * animation.bodies + body);
  const r = animation.rotations;
  return [r[at], r[at + 1], r[at + 2], r[at + 3]];
}

export function poseAt(animation: Animation, t: number, body: number): BodyPose {
  const { index, fraction } = locate(animation.time, t);
  const next = following(index, fraction);
  const a = 3 * (index * animation.bodies + body);
  const b = 3 * (next * animation.bodies + body);
  const p = animation.positions;
  const mix = (k: number) => p[a + k] + fraction * (p[b + k] - p[a + k]);
  return {
    position: [mix(0), mix(1), mix(2)],
    rotation: slerp(quaternionAt(animation, index, body), quaternionAt(animation, next, body), fraction),
  };
}

/** Amplitudes of modes [first, first + count) at `t`. */
export function amplitudesAt(animation: Animation, t: number, first: number, count: number): Float64Array {
  const { index, fraction } = locate(animation.time, t);
  const next = following(index, fraction);
  const a = index * animation.amplitudes + first;
  const b = next * animation.amplitudes + first;
  const m = animation.modes;
  const amplitudes = new Float64Array(count);
  for (let k = 0; k < count; ++k) amplitudes[k] = m[a + k] + fraction * (m[b + k] - m[a + k]);
  return amplitudes;
}

/** A curve at `t`, linearly; null before its beginning, after its end and in its gaps. */
export function valueAt(time: ArrayLike<number>, values: ArrayLike<number | null>, t: number): number | null {
  if (time.length === 0 || t < time[0] || t > time[time.length - 1]) return null;
  const { index, fraction } = locate(time, t);
  const from = values[index];
  if (fraction === 0) return from;
  const to = values[index + 1];
  return from === null || to === null ? null : from + fraction * (to - from);
}
