// The vertical range of curves laid over each other.

/** Smallest and largest of the values from `first` to `last`; null when there is none. */
export function extent(values: ArrayLike<number | null | undefined>, first: number, last: number): [number, number] | null {
  let low = Infinity;
  let high = -Infinity;
  for (let i = first; i <= last; ++i) {
    const value = values[i];
    if (value == null) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return low <= high ? [low, high] : null;
}

function hull(extents: [number, number][]): [number, number] | null {
  if (extents.length === 0) return null;
  return [Math.min(...extents.map(([low]) => low)), Math.max(...extents.map(([, high]) => high))];
}

/**
 * All of the sound runs; of the others, whose last values may be absurd, as much as leaves the sound ones half of the
 * height.
 */
export function overlayRange(sound: [number, number][], others: [number, number][]): [number, number] | null {
  const inner = hull(sound);
  const outer = hull([...sound, ...others]);
  // Constant curves have no range to compare with.
  if (!inner || !outer || !(inner[1] > inner[0])) return outer;
  const spare = (inner[1] - inner[0]) / 2;
  return [Math.max(outer[0], inner[0] - spare), Math.min(outer[1], inner[1] + spare)];
}
