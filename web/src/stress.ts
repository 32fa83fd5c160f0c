// Stresses of flexible bodies from the modal amplitudes.
import type { Body } from "./data";

/** Σ amplitude·shape, written into `out`; modes beyond those of the shapes have none. */
function linear(shapes: Float32Array, amplitudes: ArrayLike<number>, out: Float32Array): void {
  out.fill(0);
  if (out.length === 0) return;
  const modes = Math.floor(shapes.length / out.length);
  for (let mode = 0; mode < modes; ++mode) {
    const amplitude = amplitudes[mode];
    if (amplitude === 0) continue;
    const at = mode * out.length;
    for (let i = 0; i < out.length; ++i) out[i] += amplitude * shapes[at + i];
  }
}

/** xx yy zz xy yz zx per point. */
export const stresses = (body: Body, amplitudes: ArrayLike<number>, out: Float32Array) => linear(body.stress, amplitudes, out);

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

/**
 * Von Mises' stress of bars by their deflection at each point, the largest of the lines that end there: as if the largest
 * stress by N, My and Mz and that by T were at one place. `parts`: four numbers for each end of each line.
 */
export function barVonMises(body: Body, amplitudes: ArrayLike<number>, parts: Float32Array, out: Float32Array): void {
  linear(body.barStress, amplitudes, parts);
  out.fill(0);
  for (let end = 0; end < body.lines.length; ++end) {
    const [n, y, z, t] = [parts[4 * end], parts[4 * end + 1], parts[4 * end + 2], parts[4 * end + 3]];
    const bending = body.roundLines[end >> 1] ? Math.hypot(y, z) : Math.abs(y) + Math.abs(z);
    const stress = Math.hypot(Math.abs(n) + bending, t);
    const point = body.lines[end];
    if (!(stress <= out[point])) out[point] = stress; // also what is not a number
  }
}
