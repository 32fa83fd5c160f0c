// Flexible bodies: displacements of their points from the modal amplitudes.
import type { Body } from "./data";

/** u = Σ amplitude·shape, x y z per point in body axes, written into `out` (as long as the points). */
export function displacements(body: Body, amplitudes: ArrayLike<number>, out: Float32Array): void {
  out.fill(0);
  const length = body.points.length;
  if (body.pointShapes.length === 0) return;
  for (let mode = 0; mode < body.modes; ++mode) {
    const amplitude = amplitudes[mode];
    if (amplitude === 0) continue;
    const at = mode * length;
    for (let i = 0; i < length; ++i) out[i] += amplitude * body.pointShapes[at + i];
  }
}

/** points + exaggeration·u */
export function deformed(body: Body, u: Float32Array, exaggeration: number, out: Float32Array): void {
  for (let i = 0; i < out.length; ++i) out[i] = body.points[i] + exaggeration * u[i];
}

/** |u| of every point */
export function magnitudes(u: Float32Array, out: Float32Array): void {
  for (let i = 0; i < out.length; ++i) out[i] = Math.hypot(u[3 * i], u[3 * i + 1], u[3 * i + 2]);
}
