// Where the springs and dampers of a joint's own lengths are drawn: behind the joint on its axis, from a seat that goes
// with the first body to the joint on the second, so that a growing length stretches them.
import { Vector3 } from "three";
import type { Element } from "./data";
import type { Pose } from "./placement";

const sliding = /^sliding (.+) along ([xyz])$/;

export interface Slide {
  /** "spring", "damper" or both. */
  kind: string;
  /** 0: x, 1: y, 2: z of the first frame. */
  axis: number;
}

/** null where it is none. */
export function slideOf({ kind }: Pick<Element, "kind">): Slide | null {
  const found = sliding.exec(kind);
  return found && { kind: found[1], axis: "xyz".indexOf(found[2]) };
}

/** How far b is along an axis of a. */
export function lengthAlong(axis: number, a: Pose, b: Pose): number {
  return b.position.clone().sub(a.position).applyQuaternion(a.rotation.clone().invert()).getComponent(axis);
}

export class SlidingSpring {
  /** Along the axis, from a. */
  readonly seat: number;
  private least: number; // of the drawn length

  /** `travel`: the joint's smallest and largest length; `radius`: of the joint. */
  constructor(
    private axis: number,
    travel: [number, number],
    private radius: number,
  ) {
    const gap = Math.max(0.5 * (travel[1] - travel[0]), 10 * radius);
    this.seat = travel[0] - 2 * radius - gap;
    this.least = 0.2 * gap; // an exaggerated picture may go beyond the travel
  }

  /** From the seat to where the joint begins. */
  ends(a: Pose, b: Pose): [Vector3, Vector3] {
    const at = b.position.clone().sub(a.position).applyQuaternion(a.rotation.clone().invert());
    const end = Math.max(at.getComponent(this.axis) - 2 * this.radius, this.seat + this.least);
    const place = (along: number) => at.clone().setComponent(this.axis, along).applyQuaternion(a.rotation).add(a.position);
    return [place(this.seat), place(end)];
  }
}
