import assert from "node:assert/strict";
import { test } from "node:test";
import { Quaternion, Vector3 } from "three";
import type { Body, Element, Frame } from "../src/data";
import { compose, framePose, inverse, Placement, type Pose } from "../src/placement";
import { SkylineMatrix } from "../src/skyline";
import { lengthAlong, slideOf, SlidingSpring } from "../src/slidingSpring";
import { near } from "./helpers";

const identity = [1, 0, 0, 0, 1, 0, 0, 0, 1];
const frame = (body: number, position: number[], motion: number[] = []): Frame => ({ name: "", body, position, rotation: identity, motion: new Float32Array(motion) });
const joint = (kind: string, a: number, b: number): Element => ({ name: kind, kind, a, b, size: 0 });
const body = (firstMode: number, modes: number) => ({ firstMode, modes }) as Body;
const pose = (x: number, y: number, z: number, turn = 0): Pose => ({ position: new Vector3(x, y, z), rotation: new Quaternion().setFromAxisAngle(new Vector3(0, 0, 1), turn) });

/** A beam along x, held at 0, with one mode: its tip rises by the amplitude and turns by it. */
const chain = {
  bodies: [body(0, 1), body(1, 0)],
  frames: [frame(-1, [0, 0, 0]), frame(0, [0, 0, 0], [0, 0, 0, 0, 0, 0]), frame(0, [2, 0, 0], [0, 1, 0, 0, 0, 1]), frame(1, [0, 0, 0])],
  elements: [joint("fixed", 0, 1), joint("revolute", 2, 3)],
};

test("outboard bodies follow the exaggerated frames", () => {
  const placement = new Placement(chain.bodies, chain.frames, chain.elements);
  const amplitudes = [[0.01], []];
  // As the mechanism is: the second body at the tip, turned by 0.3 against it.
  const poses = [pose(0, 0, 0), pose(2, 0.01, 0, 0.31)];
  const same = placement.place(poses, amplitudes, 1);
  near(same[1].position.toArray(), [2, 0.01, 0], 1e-15);
  const placed = placement.place(poses, amplitudes, 10);
  near(placed[0].position.toArray(), [0, 0, 0], 1e-12);
  near(placed[1].position.toArray(), [2, 0.1, 0], 1e-7);
  near([2 * Math.atan2(placed[1].rotation.z, placed[1].rotation.w)], [0.3 + 0.1], 1e-7);
});

/** A parallelogram of four hinges on the ground, whose crank is flexible and stretches. */
test("a loop closes by turning its hinges, not by opening them", () => {
  const z = [0, 0, 0];
  const bodies = [body(0, 1), body(1, 0), body(1, 0)]; // crank, coupler, rocker
  const frames = [
    frame(-1, [0, 0, 0]),
    frame(0, z, [0, 0, 0, 0, 0, 0]),
    frame(0, [0, 1, 0], [0, 1, 0, 0, 0, 0]),
    frame(1, z),
    frame(1, [2, 0, 0]),
    frame(2, [0, 1, 0]),
    frame(2, z),
    frame(-1, [2, 0, 0]),
  ];
  const elements = [joint("revolute", 0, 1), joint("revolute", 2, 3), joint("revolute", 4, 5), joint("revolute", 6, 7)];
  const placement = new Placement(bodies, frames, elements);
  const amplitudes = [[0.001], [], []];
  const poses = [pose(0, 0, 0), pose(0, 1.001, 0), pose(2, 0, 0)];
  const placed = placement.place(poses, amplitudes, 100);
  const at = (k: number) => placement.at(k, placed, amplitudes, 100).position;
  for (const { a, b } of elements) assert.ok(at(a).distanceTo(at(b)) < 2e-3, `${at(a).toArray()} and ${at(b).toArray()}`);
  // The crank is drawn with its exaggerated length, and the coupler leans.
  near([at(1).distanceTo(at(2))], [1.1], 1e-6);
  assert.ok(Math.abs(placed[1].rotation.z) > 0.01);
  const true1 = placement.place(poses, amplitudes, 1);
  near(true1[1].position.toArray(), [0, 1.001, 0], 1e-15);
});

test("a mechanism that is not on the ground begins at the body that moves freely, and far from the origin", () => {
  const elements = [joint("floating", 0, 3), joint("revolute", 2, 3)];
  const origin = new Vector3(1e5, 0, 0);
  const placement = new Placement(chain.bodies, chain.frames, elements, origin);
  const poses = [pose(0, 0, 0), pose(2, 0.01, 0, 0)];
  const placed = placement.place(poses, [[0.01], []], 10);
  near(placed[1].position.toArray(), [2, 0.01, 0], 1e-12); // the root stays
  near(placement.at(2, placed, [[0.01], []], 10).position.toArray(), [2, 0.01, 0], 1e-9);
  near(placement.at(0, placed, [[0.01], []], 10).position.toArray(), [-1e5, 0, 0]);
});

test("poses compose with their inverses to nothing, frames turn by their modes", () => {
  const a = pose(1, 2, 3, 0.7);
  const none = compose(a, inverse(a));
  near([...none.position.toArray(), none.rotation.w], [0, 0, 0, 1], 1e-12);
  const turned = framePose(frame(0, [0, 0, 1], [0, 0, 0.5, 0, 0, 0.1]), [2], 3);
  near(turned.position.toArray(), [0, 0, 4], 1e-6);
  near([2 * Math.atan2(turned.rotation.z, turned.rotation.w)], [0.6], 1e-7);
});

test("the skyline solver solves least squares, and leaves alone what nothing determines", () => {
  const system = new SkylineMatrix(18, [[0, 6], [6]]);
  system.add([[0, 1], [6, -1]], 2);
  system.add([[0, 1]], 3);
  system.add([[6, 2]], 4);
  // minimise (a − b − 2)² + (a − 3)² + (2b − 4)²: 2a − b = 5, −a + 5b = 6
  const x = system.solve();
  near([x[0], x[6], x[12]], [31 / 9, 17 / 9, 0], 1e-12);
});

test("a joint's sliding spring is on its axis, and as much longer as the joint's length", () => {
  assert.deepEqual(slideOf({ kind: "sliding spring damper along x" }), { kind: "spring damper", axis: 0 });
  assert.equal(slideOf({ kind: "torsional spring about z" }), null);
  const turned = (x: number, y: number): Pose => compose(pose(3, -2, 1, 0.7), pose(x, y, 0));
  const a = turned(0, 0);
  const spring = new SlidingSpring(1, [-0.4, 0.6], 0.01);
  near([lengthAlong(1, a, turned(0.2, -0.3))], [-0.3], 1e-15);
  const length = (travel: number) => {
    const [from, to] = spring.ends(a, turned(0.2, travel));
    // Both ends are across from the joint where it is, the outer one at rest in a.
    near([lengthAlong(0, a, { ...a, position: from }), lengthAlong(0, a, { ...a, position: to })], [0.2, 0.2], 1e-14);
    near([lengthAlong(1, a, { ...a, position: from })], [spring.seat], 1e-14);
    return to.distanceTo(from);
  };
  near([length(0.6) - length(-0.4)], [1], 1e-14);
  assert.ok(length(-0.4) > 0.1 && length(-50) > 0); // also where it is drawn beyond its travel
});
