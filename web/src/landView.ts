// The land about a road: as high as its profile however far to the side, as the wheels find it, with the grid on it.
import * as THREE from "three";
import type { Patch } from "./data";
import { crossings, roadView, strip, type Point, type RoadMaterials } from "./surroundings";

const pieceCells = 40; // along the road; what is too far away to be seen is left out by the piece
const runCells = 4; // of one line: some renderers lose long ones that begin behind the eye

/** The part of the profile between two places; as much of it as there is. */
export function stretch(points: Point[], from: number, to: number): Point[] {
  if (points.length < 2 || from >= to) return [];
  const at = (x: number): Point[] => {
    const k = points.findIndex(([px], i) => px <= x && x <= points[i + 1]?.[0] && px < points[i + 1][0]);
    if (k < 0) return [];
    const [[ax, az], [bx, bz]] = [points[k], points[k + 1]];
    return [[x, az + ((x - ax) / (bx - ax)) * (bz - az)]];
  };
  return [...at(from), ...points.filter(([x]) => x > from && x < to), ...at(to)];
}

/** With points at whole multiples of `run`. */
function inRuns(points: Point[], run: number): Point[] {
  return points.flatMap((point, k) => {
    const next = points[k + 1];
    return next ? [point, ...crossings(point, next, run).filter(([x]) => x > point[0])] : [point];
  });
}

export interface LandMaterials extends RoadMaterials {
  land: THREE.Material;
  line: THREE.Material;
  patch: THREE.Material;
}

interface Piece {
  from: number;
  to: number;
  group: THREE.Group;
  wide: THREE.Group; // moves along sideways
}

export class LandView {
  readonly group = new THREE.Group();
  private pieces: Piece[] = [];

  constructor(
    points: Point[],
    patches: Patch[],
    private origin: THREE.Vector3,
    private cell: number,
    cells: number,
    halfWidth: number,
    materials: LandMaterials,
  ) {
    const half = 0.5 * cells * cell;
    const [begin, end] = [points[0][0], points[points.length - 1][0]];
    const length = pieceCells * cell;
    for (let k = Math.floor(begin / length); k * length < end; ++k) {
      const [from, to] = [Math.max(k * length, begin), Math.min((k + 1) * length, end)];
      const profile = inRuns(stretch(points, from, to), runCells * cell);
      if (profile.length < 2) continue;
      const wide = new THREE.Group().add(surface(profile, [-half, half], origin, materials.land, -4), this.lines(profile, half, materials.line));
      const group = new THREE.Group().add(wide, roadView(profile, origin, cell, halfWidth, materials, k * length <= begin));
      for (const { x, y } of patches) {
        const part = stretch(profile, Math.max(x[0], from), Math.min(x[1], to));
        if (part.length > 1) group.add(surface(part, [Math.max(y[0], -half), Math.min(y[1], half)], origin, materials.patch, -1));
      }
      this.pieces.push({ from: from - origin.x, to: to - origin.x, group, wide });
      this.group.add(group);
    }
  }

  /** Draws what lies about a place of the scene, as far as one sees. */
  look({ x, y }: THREE.Vector3, reach: number): void {
    const aside = Math.round((y + this.origin.y) / this.cell) * this.cell;
    for (const { from, to, group, wide } of this.pieces) {
      group.visible = from < x + reach && to > x - reach;
      wide.position.y = aside;
    }
  }

  private lines(profile: Point[], half: number, material: THREE.Material): THREE.LineSegments {
    const { origin, cell } = this;
    const values: number[] = [];
    const line = (a: Point, b: Point, ya: number, yb: number) =>
      values.push(a[0] - origin.x, ya - origin.y, a[1] - origin.z, b[0] - origin.x, yb - origin.y, b[1] - origin.z);
    for (let y = -half; y <= half; y += cell) for (let k = 0; k + 1 < profile.length; ++k) line(profile[k], profile[k + 1], y, y);
    const [begin, end] = [profile[0][0], profile[profile.length - 1][0]];
    for (let k = Math.ceil(begin / cell); k * cell < end; ++k) {
      const [at] = stretch(profile, k * cell, end);
      for (let y = -half; y < half; y += runCells * cell) line(at, at, y, Math.min(y + runCells * cell, half));
    }
    const made = new THREE.LineSegments(new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(values, 3)), material);
    made.renderOrder = -3;
    return made;
  }
}

function surface(profile: Point[], across: [number, number], origin: THREE.Vector3, material: THREE.Material, order: number): THREE.Mesh {
  const mesh = new THREE.Mesh(strip(profile, across, origin), material);
  mesh.receiveShadow = true;
  mesh.renderOrder = order;
  return mesh;
}
