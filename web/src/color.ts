// Turbo, the map by Mikhailov, without its dark ends: it must be seen on light and dark alike.
const stops = ["#4662d7", "#36aaf9", "#1ae4b6", "#72fe5e", "#c8ef34", "#faba39", "#f66b19", "#cb2a04"];

const components = stops.map((stop) => [1, 3, 5].map((at) => parseInt(stop.slice(at, at + 2), 16) / 255));

/** sRGB components 0..1 of a value between 0 and 1; clamped. */
export function turbo(value: number): [number, number, number] {
  const at = Math.min(Math.max(value, 0), 1) * (stops.length - 1);
  const low = Math.min(Math.floor(at), stops.length - 2);
  const part = at - low;
  const mix = (k: number) => components[low][k] + part * (components[low + 1][k] - components[low][k]);
  return [mix(0), mix(1), mix(2)];
}

export function turboGradient(direction: string): string {
  return `linear-gradient(${direction}, ${stops.join(", ")})`;
}

/** Line colours of the plots, distinguishable on light and dark backgrounds. */
export const lineColors = ["#3b82f6", "#f97316", "#10b981", "#e11d48", "#8b5cf6", "#ca8a04", "#06b6d4", "#db2777", "#65a30d", "#78716c"];
