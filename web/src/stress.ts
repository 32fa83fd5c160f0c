// Stresses of flexible bodies from the modal amplitudes.
import type { Body } from "./data";

/** Σ amplitude·stress, xx yy zz xy yz zx per point, written into `out`; modes beyond those of the stress have none. */
export function stresses(body: Body, amplitudes: ArrayLike<number>, out: Float32Array): void {
  out.fill(0);
  if (out.length === 0) return;
  const modes = Math.floor(body.stress.length / out.length);
  for (let mode = 0; mode < modes; ++mode) {
    const amplitude = amplitudes[mode];
    if (amplitude === 0) continue;
    const at = mode * out.length;
    for (let i = 0; i < out.length; ++i) out[i] += amplitude * body.stress[at + i];
  }
}

/** Von Mises' equivalent stress of every point. */
export function vonMises(stress: Float32Array, out: Float32Array): void {
  for (let i = 0; i < out.length; ++i) {
    const k = 6 * i;
    const a = stress[k] - stress[k + 1];
    const b = stress[k + 1] - stress[k + 2];
    const c = stress[k + 2] - stress[k];
    const shear = stress[k + 3] * stress[k + 3] + stress[k + 4] * stress[k + 4] + stress[k + 5] * stress[k + 5];
    out[i] = Math.sqrt((a * a + b * b + c * c) / 2 + 3 * shear);
  }
}
