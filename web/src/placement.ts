// Where bodies and frames are drawn. With deformations drawn larger than they are, bodies at the ends of flexible ones
// have to follow: joints keep what they let through as it is, and hold what they hold.
//
// Along a spanning tree of the joints each body follows exactly. Where joints close loops, a least-squares fit of all
// poses spreads what is left: directions that a joint holds weigh 1, those that it leaves free little, so that loops
// close by turning hinges rather than by opening them.
import { Matrix4, Quaternion, Vector3 } from "three";
import { poseAt, amplitudesAt } from "./interpolate";
import { SkylineMatrix } from "./skyline";
import type { Animation, Body, Element, Frame, Scene } from "./data";

export interface Pose {
  position: Vector3;
  rotation: Quaternion;
}

/** Weights of the directions that the joints leave free, relative displacement then turn in the second frame's axes. */
const loose = 0.02;
const held: Record<string, number[]> = {
  fixed: [1, 1, 1, 1, 1, 1],
  bracket: [1, 1, 1, 1, 1, 1],
  revolute: [1, 1, 1, 1, 1, loose],
  prismatic: [1, 1, loose, 1, 1, 1],
  cylindrical: [1, 1, loose, 1, 1, loose],
  universal: [1, 1, 1, loose, loose, 1],
  spherical: [1, 1, 1, loose, loose, loose],
  planar: [loose, loose, 1, 1, 1, loose],
  constant_velocity: [1, 1, 1, loose, loose, 1],
  screw: [1, 1, loose, 1, 1, loose],
};

export const isJoint = (element: Element) => element.kind in held;

export const compose = (a: Pose, b: Pose): Pose => ({
  position: b.position.clone().applyQuaternion(a.rotation).add(a.position),
  rotation: a.rotation.clone().multiply(b.rotation),
});

export const inverse = ({ position, rotation }: Pose): Pose => {
  const back = rotation.clone().conjugate();
  return { position: position.clone().negate().applyQuaternion(back), rotation: back };
};

function turnBy(vector: Vector3): Quaternion {
  const angle = vector.length();
  return angle > 0 ? new Quaternion().setFromAxisAngle(vector.clone().divideScalar(angle), angle) : new Quaternion();
}

function turnOf(rotation: Quaternion): Vector3 {
  const sign = rotation.w < 0 ? -1 : 1;
  const v = new Vector3(rotation.x, rotation.y, rotation.z).multiplyScalar(sign);
  const sine = v.length();
  return sine > 0 ? v.multiplyScalar((2 * Math.atan2(sine, sign * rotation.w)) / sine) : v;
}

/** Of a motion in the second frame's axes what a joint leaves free. */
function freePart(kind: string, { position, rotation }: Pose): Pose {
  const weights = held[kind];
  const keep = (vector: Vector3, first: number) => vector.set(...([0, 1, 2].map((k) => (weights[first + k] < 1 ? vector.getComponent(k) : 0)) as [number, number, number]));
  return { position: keep(position.clone(), 0), rotation: turnBy(keep(turnOf(rotation), 3)) };
}

/** The frame on its body, its body's deformation drawn `factor` times as large. */
export function framePose(frame: Frame, amplitudes: ArrayLike<number>, factor: number): Pose {
  const moved = [0, 0, 0, 0, 0, 0];
  for (let mode = 0; mode < frame.motion.length / 6; ++mode)
    for (let k = 0; k < 6; ++k) moved[k] += factor * amplitudes[mode] * frame.motion[6 * mode + k];
  const [a, b, c, d, e, f, g, h, i] = frame.rotation;
  const rest = new Quaternion().setFromRotationMatrix(new Matrix4().set(a, b, c, 0, d, e, f, 0, g, h, i, 0, 0, 0, 0, 1));
  return {
    position: new Vector3(...(frame.position as [number, number, number])).add(new Vector3(moved[0], moved[1], moved[2])),
    rotation: turnBy(new Vector3(moved[3], moved[4], moved[5])).multiply(rest),
  };
}

interface Edge {
  joint: Element;
  /** From the body that is placed before to the one that follows. */
  from: number;
  to: number;
}

export class Placement {
  private tree: Edge[] = [];
  private loops: Element[] = [];
  private roots = new Set<number>(); // keep their poses
  private order: number[] = []; // bodies as the tree reaches them
  private ground: Pose;

  /** `origin`: of the axes in which poses are given, global. */
  constructor(
    bodies: Body[],
    private frames: Frame[],
    elements: Element[],
    origin = new Vector3(),
  ) {
    this.ground = { position: origin.clone().negate(), rotation: new Quaternion() };
    const ends = ({ a, b }: Element) => [frames[a].body, frames[b].body];
    const joints = elements.filter((element) => isJoint(element) && element.a >= 0 && element.b >= 0);
    // A body that moves freely against the ground is where its mechanism begins: a chassis.
    const free = elements.filter(({ kind, a, b }) => kind === "floating" && a >= 0 && b >= 0).flatMap((element) => ends(element).filter((body) => body >= 0));
    const reached = new Set<number>([-1]);
    const used = new Set<Element>();
    const spread = (root: number) => {
      const queue = [root];
      for (let body = queue.shift(); body !== undefined; body = queue.shift())
        for (const joint of joints) {
          const [p, q] = ends(joint);
          const to = p === body ? q : q === body ? p : body;
          if (reached.has(to) || used.has(joint)) continue;
          reached.add(to);
          used.add(joint);
          this.tree.push({ joint, from: body, to });
          this.order.push(to);
          queue.push(to);
        }
    };
    spread(-1);
    for (const body of [...free, ...bodies.keys()]) {
      if (reached.has(body)) continue;
      reached.add(body);
      this.roots.add(body);
      spread(body);
    }
    this.loops = joints.filter((joint) => !used.has(joint) && ends(joint)[0] !== ends(joint)[1]);
  }

  get hasLoops(): boolean {
    return this.loops.length > 0;
  }

  /** A frame where it is drawn. */
  at(frame: number, placed: Pose[], amplitudes: ArrayLike<number>[], factor: number): Pose {
    const { body } = this.frames[frame];
    return compose(placed[body] ?? this.ground, framePose(this.frames[frame], amplitudes[body] ?? [], factor));
  }

  /** Poses of the bodies, exaggerated. `poses` as they are; `amplitudes` of each body. */
  place(poses: Pose[], amplitudes: ArrayLike<number>[], factor: number): Pose[] {
    const placed = poses.map(({ position, rotation }) => ({ position: position.clone(), rotation: rotation.clone() }));
    if (factor === 1 || (this.tree.length === 0 && this.loops.length === 0)) return placed;
    const local = (frame: number, by: number) => framePose(this.frames[frame], amplitudes[this.frames[frame].body] ?? [], by);
    const relative = ({ a, b }: Element) => compose(inverse(this.at(a, poses, amplitudes, 1)), this.at(b, poses, amplitudes, 1));
    for (const { joint, from } of this.tree) {
      const forward = this.frames[joint.a].body === from;
      const [near, far] = forward ? [joint.a, joint.b] : [joint.b, joint.a];
      const across = forward ? relative(joint) : inverse(relative(joint));
      placed[this.frames[far].body] = compose(compose(this.at(near, placed, amplitudes, factor), across), inverse(local(far, factor)));
    }
    if (this.loops.length > 0) this.fit(placed, relative, (frame) => local(frame, factor));
    return placed;
  }

  /** Of each joint the second frame from the first. */
  across(poses: Pose[], amplitudes: ArrayLike<number>[]): Map<Element, Pose> {
    const joints = [...this.tree.map(({ joint }) => joint), ...this.loops];
    return new Map(joints.map((joint) => [joint, compose(inverse(this.at(joint.a, poses, amplitudes, 1)), this.at(joint.b, poses, amplitudes, 1))]));
  }

  /**
   * Poses that are nearly right, with joints that hold: of its way from `rest` (across() there) each joint keeps what it leaves
   * free. Bodies follow each other along the tree; loops are closed by least squares.
   */
  close(poses: Pose[], amplitudes: ArrayLike<number>[], rest: Map<Element, Pose>): Pose[] {
    const placed = poses.map(({ position, rotation }) => ({ position: position.clone(), rotation: rotation.clone() }));
    if (this.tree.length === 0 && this.loops.length === 0) return placed;
    const now = this.across(poses, amplitudes);
    const free = new Map([...now].map(([joint, pose]) => [joint, compose(rest.get(joint)!, freePart(joint.kind, compose(inverse(rest.get(joint)!), pose)))]));
    const local = (frame: number) => framePose(this.frames[frame], amplitudes[this.frames[frame].body] ?? [], 1);
    for (const { joint, from } of this.tree) {
      const forward = this.frames[joint.a].body === from;
      const [near, far] = forward ? [joint.a, joint.b] : [joint.b, joint.a];
      const across = forward ? free.get(joint)! : inverse(free.get(joint)!);
      placed[this.frames[far].body] = compose(compose(this.at(near, placed, amplitudes, 1), across), inverse(local(far)));
    }
    if (this.loops.length > 0) this.fit(placed, (joint) => free.get(joint)!, local);
    return placed;
  }

  /** Gauss–Newton on the poses of the bodies that joints reach. */
  private fit(placed: Pose[], relative: (joint: Element) => Pose, local: (frame: number) => Pose): void {
    const joints = [...this.tree.map(({ joint }) => joint), ...this.loops];
    const place = new Map(this.order.map((body, k) => [body, 6 * k]));
    const wanted = new Map(joints.map((joint) => [joint, relative(joint)]));
    const locals = new Map(joints.map((joint) => [joint, [local(joint.a), local(joint.b)]]));
    const bodyOf = (frame: number) => this.frames[frame].body;
    const length = this.size(placed);
    for (let iteration = 0; iteration < 6; ++iteration) {
      const system = new SkylineMatrix(6 * this.order.length, joints.map(({ a, b }) => [place.get(bodyOf(a)), place.get(bodyOf(b))].filter((at): at is number => at !== undefined)));
      let change = 0;
      for (const joint of joints) {
        const [localA, localB] = locals.get(joint)!;
        const bodyA = placed[bodyOf(joint.a)] ?? this.ground;
        const bodyB = placed[bodyOf(joint.b)] ?? this.ground;
        const target = compose(compose(bodyA, localA), wanted.get(joint)!);
        const is = compose(bodyB, localB);
        const error = compose(inverse(target), is);
        const turn = turnOf(error.rotation);
        const axes = [0, 1, 2].map((k) => new Vector3().setComponent(k, 1).applyQuaternion(target.rotation));
        const weights = held[joint.kind];
        for (let k = 0; k < 6; ++k) {
          const axis = axes[k % 3];
          const w = weights[k];
          const row: [number, number][] = [];
          for (const [sign, body, pose] of [[-1, bodyOf(joint.a), bodyA], [1, bodyOf(joint.b), bodyB]] as [number, number, Pose][]) {
            const column = place.get(body);
            if (column === undefined) continue;
            // Unknowns: displacement of the body over `length`, and its small turn, both in global axes.
            const lever = k < 3 ? is.position.clone().sub(pose.position).cross(axis).divideScalar(length) : axis;
            for (let i = 0; i < 3; ++i) {
              if (k < 3) row.push([column + i, sign * w * axis.getComponent(i)]);
              row.push([column + 3 + i, sign * w * lever.getComponent(i)]);
            }
          }
          const residual = w * (k < 3 ? error.position.getComponent(k) / length : turn.getComponent(k - 3));
          system.add(row, -residual);
        }
      }
      const step = system.solve();
      for (const [body, at] of place) {
        const pose = placed[body];
        pose.position.add(new Vector3(step[at], step[at + 1], step[at + 2]).multiplyScalar(length));
        pose.rotation.premultiply(turnBy(new Vector3(step[at + 3], step[at + 4], step[at + 5]))).normalize();
        for (let i = 0; i < 6; ++i) change = Math.max(change, Math.abs(step[at + i]));
      }
      if (change < 1e-4) return;
    }
  }

  /** How far the bodies are apart. */
  private size(placed: Pose[]): number {
    const centre = placed.reduce((sum, { position }) => sum.add(position), new Vector3()).divideScalar(placed.length);
    return Math.max(...placed.map(({ position }) => position.distanceTo(centre)), 1e-9);
  }
}

/** The bodies of a scene at a time; null where the results hold no finite pose. */
export function posesAt(animation: Animation, time: number, origin: Vector3): (Pose | null)[] {
  return Array.from({ length: animation.bodies }, (_, body) => {
    const { position, rotation } = poseAt(animation, time, body);
    if (![...position, ...rotation].every(Number.isFinite)) return null;
    const [w, x, y, z] = rotation;
    return { position: new Vector3(...position).sub(origin), rotation: new Quaternion(x, y, z, w) };
  });
}

export function amplitudesOf(scene: Scene, time: number): Float64Array[] {
  return scene.bodies.map(({ firstMode, modes }) => amplitudesAt(scene.animation, time, firstMode, modes));
}
