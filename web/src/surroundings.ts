// What bodies move in: roads and the ground grid.
import * as THREE from "three";

export type Point = [x: number, z: number];

export function finiteProfile(profile: Float64Array): Point[] {
  const points: Point[] = [];
  for (let i = 0; i + 1 < profile.length; i += 2)
    if (Number.isFinite(profile[i]) && Number.isFinite(profile[i + 1])) points.push([profile[i], profile[i + 1]]);
  return points;
}

/** Points of the segment from p to q at whole multiples of `spacing` in x, q's end excluded. */
export function crossings(p: Point, q: Point, spacing: number): Point[] {
  const found: Point[] = [];
  const slope = (q[1] - p[1]) / (q[0] - p[0]);
  for (let k = Math.ceil(p[0] / spacing); k * spacing < q[0]; ++k)
    found.push([k * spacing, p[1] + slope * (k * spacing - p[0])]);
  return found;
}

export interface RoadMaterials {
  surface: THREE.Material;
  border: THREE.Material;
  mark: THREE.Material;
}

/** The profile extruded across, from one y to another. */
export function strip(points: Point[], [low, high]: [number, number], origin: THREE.Vector3): THREE.BufferGeometry {
  const at = ([x, z]: Point, y: number) => [x - origin.x, y - origin.y, z - origin.z];
  const triangles: number[] = [];
  for (let i = 0; i + 1 < points.length; ++i) {
    const [p, q] = [points[i], points[i + 1]];
    if (p[0] === q[0] && p[1] === q[1]) continue;
    triangles.push(...at(p, high), ...at(p, low), ...at(q, low), ...at(p, high), ...at(q, low), ...at(q, high));
  }
  const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(triangles, 3));
  geometry.computeVertexNormals();
  return geometry;
}

/**
 * The profile extruded across by `halfWidth` to both sides; lines along its borders and where it bends (`begins`: at its
 * first point too), fainter marks at equal distances.
 */
export function roadView(points: Point[], origin: THREE.Vector3, spacing: number, halfWidth: number, materials: RoadMaterials, begins = true): THREE.Group {
  const at = ([x, z]: Point, side: number) => [x - origin.x, side * halfWidth - origin.y, z - origin.z];
  const borders: number[] = [];
  const marks: number[] = [];
  let direction: number | undefined;
  for (let i = 0; i + 1 < points.length; ++i) {
    const [p, q] = [points[i], points[i + 1]];
    if (p[0] === q[0] && p[1] === q[1]) continue;
    for (const side of [-1, 1]) borders.push(...at(p, side), ...at(q, side));
    const next = Math.atan2(q[1] - p[1], q[0] - p[0]);
    if (direction === undefined ? begins : Math.abs(next - direction) > 0.02) borders.push(...at(p, -1), ...at(p, 1));
    direction = next;
    for (const crossing of crossings(p, q, spacing)) marks.push(...at(crossing, -1), ...at(crossing, 1));
  }
  const geometry = (values: number[]) =>
    new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(values, 3));
  const mesh = new THREE.Mesh(strip(points, [-halfWidth, halfWidth], origin), materials.surface);
  mesh.receiveShadow = true;
  mesh.renderOrder = -2; // over the lines of the land
  const border = new THREE.LineSegments(geometry(borders), materials.border);
  return new THREE.Group().add(mesh, border, new THREE.LineSegments(geometry(marks), materials.mark));
}

/** 1, 2 or 5 times a power of ten, not above `length`. */
export function niceLength(length: number): number {
  const power = 10 ** Math.floor(Math.log10(length));
  const lead = length / power;
  return power * (lead >= 5 ? 5 : lead >= 2 ? 2 : 1);
}

const piece = 4; // cells

/**
 * A horizontal grid; it is moved along by whole cells, so that it seems endless. Its lines are of short pieces: some
 * renderers lose long ones that begin behind the eye.
 */
export function gridView(cell: number, cells: number, color: string): THREE.LineSegments {
  const half = (cells / 2) * cell;
  const points: number[] = [];
  for (let k = 0; k <= cells; ++k)
    for (let from = 0; from < cells; from += piece) {
      const [across, a, b] = [k * cell - half, from * cell - half, Math.min(from + piece, cells) * cell - half];
      points.push(across, a, 0, across, b, 0, a, across, 0, b, across, 0);
    }
  const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color, transparent: true, opacity: 0.6 }));
}
