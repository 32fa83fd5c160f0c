// Numbers of a curve over a stretch of time.

export interface Statistics {
  min: number;
  minAt: number;
  max: number;
  maxAt: number;
  /** Over time, by the trapezoidal rule. */
  mean: number;
  /** Root of the mean square over time; the square of a straight line is integrated exactly. */
  rms: number;
}

/** null where there is no finite value in [from, to]. Gaps are left out. */
export function statistics(time: ArrayLike<number>, values: ArrayLike<number | null>, from = -Infinity, to = Infinity): Statistics | null {
  const all = { min: Infinity, minAt: NaN, max: -Infinity, maxAt: NaN };
  let length = 0;
  let area = 0;
  let squares = 0;
  let last: number | null = null;
  let lastTime = 0;
  for (let i = 0; i < time.length; ++i) {
    const value = time[i] >= from && time[i] <= to ? values[i] : null;
    if (value === null) {
      last = null;
      continue;
    }
    if (value < all.min) [all.min, all.minAt] = [value, time[i]];
    if (value > all.max) [all.max, all.maxAt] = [value, time[i]];
    if (last !== null) {
      const h = time[i] - lastTime;
      length += h;
      area += (h * (last + value)) / 2;
      squares += (h * (last * last + last * value + value * value)) / 3;
    }
    last = value;
    lastTime = time[i];
  }
  if (all.min > all.max) return null;
  const alone = length > 0 ? null : all.min;
  return { ...all, mean: alone ?? area / length, rms: alone === null ? Math.sqrt(squares / length) : Math.abs(alone) };
}
