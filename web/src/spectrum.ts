// Amplitudes of a curve over frequency.
import { valueAt } from "./interpolate";

export type Window = "hann" | "flat top" | "none";

/** Of samples k of n. A flat top reads the height of a peak between two lines to 0.1 %, a Hann window separates better. */
function weight(window: Window, k: number, n: number): number {
  const c = (m: number) => Math.cos((2 * Math.PI * m * k) / n);
  if (window === "hann") return 0.5 - 0.5 * c(1);
  if (window === "flat top") return 0.21557895 - 0.41663158 * c(1) + 0.277263158 * c(2) - 0.083578947 * c(3) + 0.006947368 * c(4);
  return 1;
}

/** In place, of a length that is a power of two: X_m = Σ x_k exp(−2πi km/n). */
export function transform(re: Float64Array, im: Float64Array): void {
  const n = re.length;
  for (let i = 1, j = 0; i < n; ++i) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      [re[i], re[j]] = [re[j], re[i]];
      [im[i], im[j]] = [im[j], im[i]];
    }
  }
  for (let length = 2; length <= n; length *= 2) {
    const half = length / 2;
    for (let k = 0; k < half; ++k) {
      const c = Math.cos((2 * Math.PI * k) / length);
      const s = -Math.sin((2 * Math.PI * k) / length);
      for (let a = k; a < n; a += length) {
        const b = a + half;
        const x = c * re[b] - s * im[b];
        const y = c * im[b] + s * re[b];
        re[b] = re[a] - x;
        im[b] = im[a] - y;
        re[a] += x;
        im[a] += y;
      }
    }
  }
}

export interface Spectrum {
  frequency: number[]; // Hz
  /** Of a sine of that frequency, in the curve's unit; the mean is taken off before. */
  amplitude: number[];
}

/**
 * Of the curve in [from, to], sampled evenly as often as it has instants there (linearly between them), windowed,
 * padded with noughts to a power of two. Empty for fewer than eight instants or with gaps.
 */
export function spectrum(time: ArrayLike<number>, values: ArrayLike<number | null>, window: Window, from = -Infinity, to = Infinity): Spectrum {
  let first = 0;
  let last = time.length - 1;
  while (first < time.length && time[first] < from) ++first;
  while (last >= 0 && time[last] > to) --last;
  const count = last - first + 1;
  const none = { frequency: [], amplitude: [] };
  if (count < 8) return none;
  const h = (time[last] - time[first]) / (count - 1);
  const sampled = new Float64Array(count);
  for (let k = 0; k < count; ++k) {
    const value = valueAt(time, values, k === count - 1 ? time[last] : time[first] + k * h);
    if (value === null || !(h > 0)) return none;
    sampled[k] = value;
  }
  const mean = sampled.reduce((sum, value) => sum + value, 0) / count;
  let padded = 8;
  while (padded < 2 * count) padded *= 2;
  const re = new Float64Array(padded);
  const im = new Float64Array(padded);
  let gain = 0;
  for (let k = 0; k < count; ++k) {
    const w = weight(window, k, count);
    gain += w;
    re[k] = w * (sampled[k] - mean);
  }
  transform(re, im);
  const result: Spectrum = { frequency: [], amplitude: [] };
  for (let m = 0; m <= padded / 2; ++m) {
    result.frequency.push(m / (padded * h));
    result.amplitude.push((2 * Math.hypot(re[m], im[m])) / gain);
  }
  return result;
}

/** Up to where there is something to see: half as far again as the last amplitude above a hundredth of the largest. */
export function telling({ frequency, amplitude }: Spectrum): number {
  const most = amplitude.reduce((a, b) => Math.max(a, b), 0);
  let last = amplitude.length - 1;
  while (last > 0 && amplitude[last] < 0.01 * most) --last;
  return Math.min(1.5 * frequency[last], frequency[frequency.length - 1]) || frequency[frequency.length - 1];
}
