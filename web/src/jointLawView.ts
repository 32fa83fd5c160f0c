// Force elements on a joint's coordinate: a motor's case, a ring of friction, a stop's block, next to the joint.
import * as THREE from "three";

const pattern = /^(motor|friction|stop) (about|along) ([xyz])$/;

export const isJointLaw = (kind: string) => pattern.test(kind);

/** "friction of the joint" */
export const jointLawText = (kind: string) => kind.replace(pattern, "$1 of the joint");

/** In the axes of the joint's first frame; `radius`: of the joint that it is next to. */
export function jointLawMesh(kind: string, radius: number, materials: { actuator: THREE.Material; damper: THREE.Material; rod: THREE.Material }): THREE.Mesh {
  const [, law, way, axis] = pattern.exec(kind)!;
  const r = radius;
  const turns = way === "about";
  let geometry: THREE.BufferGeometry;
  // Along z, and on the side where no spring of the joint is.
  if (law === "motor") geometry = turns ? new THREE.CylinderGeometry(1.3 * r, 1.3 * r, 2 * r, 24).rotateX(Math.PI / 2).translate(0, 0, -3.2 * r) : new THREE.BoxGeometry(1.2 * r, 1.2 * r, 3 * r).translate(0, -1.6 * r, 0);
  else if (law === "friction") geometry = turns ? new THREE.TorusGeometry(1.5 * r, 0.3 * r, 12, 32).translate(0, 0, 1.2 * r) : new THREE.BoxGeometry(2.2 * r, 0.4 * r, 2.4 * r).translate(0, 1.1 * r, 0);
  else geometry = turns ? new THREE.BoxGeometry(0.7 * r, 0.7 * r, 1.6 * r).translate(1.7 * r, 0, 0) : new THREE.BoxGeometry(2.4 * r, 2.4 * r, 0.5 * r).translate(0, 0, 2.6 * r);
  if (axis === "x") geometry.rotateY(Math.PI / 2);
  if (axis === "y") geometry.rotateX(-Math.PI / 2);
  return new THREE.Mesh(geometry, { motor: materials.actuator, friction: materials.damper, stop: materials.rod }[law as "motor" | "friction" | "stop"]);
}
