// From where an eye sees all of some points.
import * as THREE from "three";

/**
 * The point to look at and the distance from it, in a direction (from there to the eye, of length 1; z is up in the picture),
 * so that all points fill the share `filled` of the picture; `tangent` of half its vertical angle.
 */
export function framing(points: THREE.Vector3[], direction: THREE.Vector3, tangent: number, aspect: number, filled = 0.84): { center: THREE.Vector3; distance: number } {
  const right = new THREE.Vector3(-direction.y, direction.x, 0).normalize();
  const up = direction.clone().cross(right);
  const center = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3());
  let distance = 0;
  // The second time with what is near weighed as the perspective shows it.
  for (let pass = 0; pass < 3; ++pass) {
    const weight = (depth: number) => (pass > 0 && distance > depth ? distance / (distance - depth) : 1);
    const sides = [right, up].map((axis) => {
      const along = points.map((point) => {
        const offset = point.clone().sub(center);
        return offset.dot(axis) * weight(offset.dot(direction));
      });
      return (along.reduce((a, b) => Math.min(a, b), Infinity) + along.reduce((a, b) => Math.max(a, b), -Infinity)) / 2;
    });
    center.addScaledVector(right, sides[0]).addScaledVector(up, sides[1]);
    distance = points.reduce((most, point) => {
      const offset = point.clone().sub(center);
      return Math.max(most, offset.dot(direction) + Math.max(Math.abs(offset.dot(right)) / aspect, Math.abs(offset.dot(up))) / (tangent * filled));
    }, 0);
  }
  return { center, distance };
}
