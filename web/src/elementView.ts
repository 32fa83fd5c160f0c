// Joints, springs, dampers and rigs' plates between the bodies.
import * as THREE from "three";
import { isJoint, type Pose } from "./placement";
import type { Element } from "./data";
import { CouplingView, isCoupling } from "./couplingView";
import { isJointLaw, jointLawMesh } from "./jointLawView";
import { slideOf, SlidingSpring } from "./slidingSpring";
import { isTorsional, TorsionView } from "./torsionView";

const up = new THREE.Vector3(0, 1, 0);

function coil(turns: number, length: number, radius: number, wire: number): THREE.BufferGeometry {
  const points = Array.from({ length: 16 * turns + 1 }, (_, i) => {
    const t = i / (16 * turns);
    // Straight ends, as of a coil spring with hooks.
    const s = Math.min(Math.max((t - 0.08) / 0.84, 0), 1);
    const r = radius * Math.min(1, 20 * s, 20 * (1 - s));
    const angle = 2 * Math.PI * turns * s;
    return new THREE.Vector3(r * Math.cos(angle), length * t, r * Math.sin(angle));
  });
  return new THREE.TubeGeometry(new THREE.CatmullRomCurve3(points), 24 * turns, wire, 7);
}

/** Of a spring or damper so long. */
const coilRadius = (length: number, size: number) => Math.min(0.11 * length, 0.02 * size);

/** From the first of two points towards the second. */
interface Part {
  mesh: THREE.Mesh;
  /** Of the geometry, along y. */
  length: number;
  /** Up to the second point, or as long as it is. */
  stretches: boolean;
}

function between(kind: string, length: number, size: number, materials: ElementMaterials): Part[] {
  const radius = coilRadius(length, size);
  const parts: Part[] = [];
  const rod = (r: number, l: number) => new THREE.CylinderGeometry(r, r, l, 20).translate(0, l / 2, 0);
  const add = (geometry: THREE.BufferGeometry, material: THREE.Material, of: number, stretches: boolean) =>
    parts.push({ mesh: new THREE.Mesh(geometry, material), length: of, stretches });
  if (kind.startsWith("spring")) add(coil(8, length, radius, 0.17 * radius), materials.spring, length, true);
  if (kind === "distance") add(rod(0.35 * radius, length), materials.rod, length, true);
  else if (kind !== "spring") {
    const thick = radius * (kind === "spring damper" ? 0.55 : 0.8);
    add(rod(thick, 0.55 * length), kind === "actuator" ? materials.actuator : materials.damper, 0.55 * length, false);
    add(rod(0.35 * thick, length), materials.rod, length, true);
  }
  return parts;
}

/** Through its points, in the axes of the frame that carries it. */
function curveMesh(points: Float32Array, radius: number, material: THREE.Material): THREE.Mesh {
  const at = Array.from({ length: points.length / 3 }, (_, k) => new THREE.Vector3().fromArray(points, 3 * k));
  return new THREE.Mesh(new THREE.TubeGeometry(new THREE.CatmullRomCurve3(at), 2 * at.length, 0.3 * radius, 8), material);
}

/** A joint's own shape, in its frame's axes, z along its axis. */
function jointShape(kind: string, r: number): THREE.BufferGeometry[] {
  const along = (radius: number, length: number) => new THREE.CylinderGeometry(radius, radius, length, 24).rotateX(Math.PI / 2);
  if (kind === "revolute") return [along(r, 2.4 * r), along(0.45 * r, 3.4 * r)];
  if (kind === "prismatic") return [new THREE.BoxGeometry(1.7 * r, 1.7 * r, 4 * r)];
  if (kind === "cylindrical" || kind === "screw") return [along(r, 4 * r)];
  if (kind === "universal") return [along(0.45 * r, 3 * r).rotateX(Math.PI / 2), along(0.45 * r, 3 * r).rotateY(Math.PI / 2), new THREE.BoxGeometry(r, r, r)];
  if (kind === "spherical" || kind === "constant_velocity") return [new THREE.SphereGeometry(1.15 * r, 24, 16)];
  if (kind === "planar") return [new THREE.BoxGeometry(4 * r, 4 * r, 0.4 * r)];
  if (kind === "bushing") return [new THREE.TorusGeometry(1.3 * r, 0.6 * r, 16, 32)];
  if (kind === "floating") return [];
  if (kind.startsWith("on_")) return [new THREE.SphereGeometry(0.7 * r, 24, 16)]; // a point on a line, plane or curve
  return [new THREE.BoxGeometry(1.3 * r, 1.3 * r, 1.3 * r)]; // held in all directions
}

export interface ElementMaterials {
  spring: THREE.MeshStandardMaterial;
  damper: THREE.MeshStandardMaterial;
  actuator: THREE.MeshStandardMaterial;
  rod: THREE.MeshStandardMaterial;
  joint: THREE.MeshStandardMaterial;
}

export function elementMaterials(): ElementMaterials {
  const metal = (color: string) => new THREE.MeshStandardMaterial({ color, roughness: 0.4, metalness: 0.25 });
  return { spring: metal("#d1495b"), damper: metal("#5c6b7a"), actuator: metal("#2a9d8f"), rod: metal("#aab4bf"), joint: metal("#e9b44c") };
}

export class ElementView {
  readonly group = new THREE.Group();
  readonly isJoint: boolean;
  private parts: Part[] = [];
  private torsion?: TorsionView;
  private sliding?: SlidingSpring;
  private coupling?: CouplingView;
  /** What goes with the first frame: a curve, a motor. */
  private first?: THREE.Mesh;

  constructor(
    readonly element: Element,
    a: Pose | null,
    b: Pose | null,
    size: number,
    /** Of the bars that a joint holds, to be seen around them. */
    thickness: number,
    materials: ElementMaterials,
    /** Of a joint's sliding spring: the smallest and the largest length. */
    travel: [number, number] = [0, 0],
  ) {
    const { kind } = element;
    const slide = slideOf(element);
    this.isJoint = isJoint(element) || kind === "floating" || kind === "bushing" || kind.startsWith("on_");
    this.group.name = element.name;
    const radius = Math.min(Math.max(0.008 * size, 1.3 * thickness), 0.03 * size); // of a joint
    if (isCoupling(kind)) {
      this.coupling = new CouplingView(this.group, kind, radius, materials);
    } else if (isJointLaw(kind)) {
      this.first = jointLawMesh(kind, radius, materials);
      this.group.add(this.first);
    } else if (this.isJoint) {
      for (const geometry of jointShape(kind, radius)) this.group.add(new THREE.Mesh(geometry, kind === "bushing" ? materials.damper : materials.joint));
      if (element.curve) {
        this.first = curveMesh(element.curve, radius, materials.rod);
        this.group.add(this.first);
      }
    } else if (isTorsional(element)) {
      if (a && b) this.torsion = new TorsionView(this.group, element, a, b, radius, materials);
    } else if (a && b) {
      if (slide) this.sliding = new SlidingSpring(slide.axis, travel, radius);
      const [from, to] = this.ends(a, b);
      const length = Math.max(from.distanceTo(to), 1e-6 * size);
      this.parts = between(slide?.kind ?? kind, length, size, materials);
      if (slide) {
        const wide = 1.4 * coilRadius(length, size);
        this.group.add(new THREE.Mesh(new THREE.CylinderGeometry(wide, wide, 0.25 * wide, 24), materials.rod));
      }
      for (const { mesh } of this.parts) this.group.add(mesh);
    }
    for (const mesh of this.group.children) mesh.castShadow = true;
  }

  /** Between frames where they are drawn now. */
  update(a: Pose, b: Pose): void {
    if (this.torsion) return this.torsion.update(a, b);
    if (this.coupling) return this.coupling.update(a, b);
    if (this.first && !this.isJoint) {
      this.group.position.copy(a.position);
      this.group.quaternion.copy(a.rotation);
      return;
    }
    if (this.isJoint) {
      this.group.position.copy(b.position);
      this.group.quaternion.copy(b.rotation);
      if (this.first) {
        const back = b.rotation.clone().conjugate();
        this.first.position.copy(a.position).sub(b.position).applyQuaternion(back);
        this.first.quaternion.copy(back).multiply(a.rotation);
      }
      return;
    }
    const [from, to] = this.ends(a, b);
    const along = to.sub(from);
    const length = along.length();
    this.group.position.copy(from);
    this.group.quaternion.setFromUnitVectors(up, length > 0 ? along.divideScalar(length) : up);
    for (const part of this.parts) if (part.stretches) part.mesh.scale.y = Math.max(length / part.length, 1e-9);
  }

  private ends(a: Pose, b: Pose): [THREE.Vector3, THREE.Vector3] {
    return this.sliding ? this.sliding.ends(a, b) : [a.position, b.position.clone()];
  }
}
