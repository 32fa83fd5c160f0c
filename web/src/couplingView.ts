// What couples two frames without being a body between them: dashed lines, and axes that are kept parallel or at right angles.
import * as THREE from "three";
import type { Pose } from "./placement";

const up = new THREE.Vector3(0, 1, 0);

export const isCoupling = (kind: string) => kind === "coupling" || kind === "coupling spring" || keepsAxes(kind);
const keepsAxes = (kind: string) => kind === "parallel" || kind === "perpendicular";

/** Along y up to 1, so many dashes with gaps of their size between them. */
export function dashes(count: number): THREE.BufferGeometry {
  const steps = 2 * count - 1;
  const tube = new THREE.CylinderGeometry(1, 1, 1, 8, steps, true).translate(0, 0.5, 0);
  const position = tube.getAttribute("position");
  const index = tube.getIndex()!;
  const kept: number[] = [];
  for (let k = 0; k < index.count; k += 3) {
    const corners = [0, 1, 2].map((i) => index.getX(k + i));
    const middle = Math.min(...corners.map((corner) => position.getY(corner))) + 0.5 / steps;
    if (Math.floor(steps * middle) % 2 === 0) kept.push(...corners);
  }
  tube.setIndex(kept);
  return tube;
}

export class CouplingView {
  private line: THREE.Mesh;
  /** Along the axis of the first frame and of the second. */
  private axes: THREE.Mesh[] = [];

  constructor(
    group: THREE.Group,
    kind: string,
    private radius: number,
    materials: { spring: THREE.Material; rod: THREE.Material; joint: THREE.Material },
  ) {
    this.line = new THREE.Mesh(dashes(9), kind === "coupling spring" ? materials.spring : materials.joint);
    group.add(this.line);
    if (!keepsAxes(kind)) return;
    const rod = new THREE.CylinderGeometry(0.35 * radius, 0.35 * radius, 7 * radius, 12).rotateX(Math.PI / 2);
    this.axes = [new THREE.Mesh(rod, materials.joint), new THREE.Mesh(rod, materials.rod)];
    group.add(...this.axes);
  }

  update(a: Pose, b: Pose): void {
    const along = b.position.clone().sub(a.position);
    const length = along.length();
    const thick = 0.25 * this.radius;
    this.line.position.copy(a.position);
    this.line.quaternion.setFromUnitVectors(up, length > 0 ? along.divideScalar(length) : up);
    this.line.scale.set(thick, Math.max(length, 1e-9), thick);
    this.axes.forEach((axis, k) => {
      const pose = k === 0 ? a : b;
      axis.position.copy(pose.position);
      axis.quaternion.copy(pose.rotation);
    });
  }
}
