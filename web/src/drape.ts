// Parts of a surface between two places along and across: what is painted on uneven ground.

type Corner = [x: number, y: number, z: number];

/** The part of a polygon where coordinate `axis` is above `limit`, or below it. */
function cut(polygon: Corner[], axis: 0 | 1, limit: number, above: boolean): Corner[] {
  const inside = (p: Corner) => (above ? p[axis] >= limit : p[axis] <= limit);
  return polygon.flatMap((p, k) => {
    const next = polygon[(k + 1) % polygon.length];
    const kept = inside(p) ? [p] : [];
    if (inside(p) === inside(next)) return kept;
    const t = (limit - p[axis]) / (next[axis] - p[axis]);
    return [...kept, p.map((value, i) => value + t * (next[i] - value)) as Corner];
  });
}

/** Corners x y z of the triangles (nine numbers each) that cover `points` with `triangles` between the places. */
export function drape(points: ArrayLike<number>, triangles: ArrayLike<number>, x: [number, number], y: [number, number]): number[] {
  const covered: number[] = [];
  for (let k = 0; k + 2 < triangles.length; k += 3) {
    const corners = [0, 1, 2].map((i) => [0, 1, 2].map((axis) => points[3 * triangles[k + i] + axis]) as Corner);
    const beside = ([low, high]: [number, number], axis: 0 | 1) => corners.every((p) => p[axis] <= low) || corners.every((p) => p[axis] >= high);
    if (beside(x, 0) || beside(y, 1)) continue;
    const part = cut(cut(cut(cut(corners, 0, x[0], true), 0, x[1], false), 1, y[0], true), 1, y[1], false);
    for (let i = 1; i + 1 < part.length; ++i) covered.push(...part[0], ...part[i], ...part[i + 1]);
  }
  return covered;
}
