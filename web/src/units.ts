// Units that keep the numbers of a scale short.

const steps = {
  m: [["µm", 1e-6], ["mm", 1e-3], ["m", 1], ["km", 1e3]],
  Pa: [["Pa", 1], ["kPa", 1e3], ["MPa", 1e6], ["GPa", 1e9], ["TPa", 1e12]],
} as const;

/** The largest unit in which `value` is at least 1, or the smallest. */
export function unitFor(value: number, base: keyof typeof steps): { unit: string; size: number } {
  let [unit, size]: readonly [string, number] = steps[base][0];
  for (const [name, step] of steps[base]) if (Math.abs(value) >= step) [unit, size] = [name, step];
  return { unit, size };
}
