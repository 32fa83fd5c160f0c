// The springs and dampers of a joint's own turning coordinates: a spiral that winds up, a drum for the damper.
import * as THREE from "three";
import type { Element } from "./data";
import type { Pose } from "./placement";

const turns = 3;

export const isTorsional = ({ kind }: Pick<Element, "kind">) => kind.startsWith("torsional ");

/** The angle by which b is turned against a about a joint's axis: of a universal joint R = Rx(q0) Ry(q1), else Rz. */
export function turnAbout(axis: string, a: THREE.Quaternion, b: THREE.Quaternion): number {
  const matrix = new THREE.Matrix4().makeRotationFromQuaternion(a.clone().invert().multiply(b));
  const r = (row: number, column: number) => matrix.elements[4 * column + row];
  if (axis === "x") return Math.atan2(r(2, 1), r(1, 1));
  if (axis === "y") return Math.atan2(r(0, 2), r(0, 0));
  return Math.atan2(r(1, 0), r(0, 0));
}

/** From y about z the wire goes outwards; `inward` of its vertices: 0 at the outer end, 1 at the inner one. */
function spiral(inner: number, outer: number, wire: number): { geometry: THREE.BufferGeometry; inward: Float32Array } {
  const sections = 40 * turns;
  const sides = 6;
  const along = Array.from({ length: sections + 1 }, (_, i) => i / sections);
  const path = new THREE.CatmullRomCurve3(along.map((s) => new THREE.Vector3(Math.cos(2 * Math.PI * turns * s), Math.sin(2 * Math.PI * turns * s), 0).multiplyScalar(outer + (inner - outer) * s)));
  const geometry = new THREE.TubeGeometry(path, sections, wire, sides);
  const inward = Float32Array.from({ length: geometry.getAttribute("position").count }, (_, k) => Math.floor(k / (sides + 1)) / sections);
  return { geometry, inward };
}

export class TorsionView {
  private axis: string;
  private turned = new THREE.Quaternion(); // from z to the axis
  private spring?: { mesh: THREE.Mesh; rest: Float32Array; inward: Float32Array };
  private start: number;

  /** `radius` of the joint that it is around. */
  constructor(
    private group: THREE.Group,
    { kind }: Element,
    a: Pose,
    b: Pose,
    radius: number,
    materials: { spring: THREE.Material; damper: THREE.Material },
  ) {
    this.axis = kind[kind.length - 1];
    if (this.axis === "x") this.turned.setFromAxisAngle(new THREE.Vector3(0, 1, 0), Math.PI / 2);
    if (this.axis === "y") this.turned.setFromAxisAngle(new THREE.Vector3(1, 0, 0), -Math.PI / 2);
    this.start = turnAbout(this.axis, a.rotation, b.rotation);
    const offset = 1.75 * radius; // past the end of the joint's pin
    if (/\bdamper\b/.test(kind)) {
      const drum = new THREE.CylinderGeometry(1.4 * radius, 1.4 * radius, 0.7 * radius, 24).rotateX(Math.PI / 2).translate(0, 0, -offset);
      group.add(new THREE.Mesh(drum, materials.damper));
    }
    if (!/\bspring\b/.test(kind)) return;
    const { geometry, inward } = spiral(0.6 * radius, 2.6 * radius, 0.2 * radius);
    geometry.translate(0, 0, offset);
    const mesh = new THREE.Mesh(geometry, materials.spring);
    group.add(mesh);
    this.spring = { mesh, inward, rest: Float32Array.from(geometry.getAttribute("position").array) };
  }

  /** The outer end goes with a, the inner one with b. */
  update(a: Pose, b: Pose): void {
    this.group.position.copy(b.position);
    const start = new THREE.Quaternion(); // the second axis of a universal joint is turned by the first
    if (this.axis === "y") start.setFromAxisAngle(new THREE.Vector3(1, 0, 0), turnAbout("x", a.rotation, b.rotation));
    this.group.quaternion.copy(a.rotation).multiply(start).multiply(this.turned);
    if (!this.spring) return;
    const { mesh, rest, inward } = this.spring;
    const turn = turnAbout(this.axis, a.rotation, b.rotation) - this.start;
    const positions = mesh.geometry.getAttribute("position") as THREE.BufferAttribute;
    for (let k = 0; k < inward.length; ++k) {
      const [c, s] = [Math.cos(turn * inward[k]), Math.sin(turn * inward[k])];
      const [x, y] = [rest[3 * k], rest[3 * k + 1]];
      positions.setXY(k, c * x - s * y, s * x + c * y);
    }
    positions.needsUpdate = true;
  }
}
