import assert from "node:assert/strict";
import { test } from "node:test";
import { Quaternion, Vector3 } from "three";
import { decibels, decodeBode, firstInput, firstOutputs, magnitudes, phases, phaseTicks, ratioUnit, responseOf } from "../src/bodeData";
import { logarithmicTicks } from "../src/engineering";
import { dampingText, valueText } from "../src/mechanismModeList";
import { bendingMode, ClosedJoints, decodeMechanismModes, drawingFactor, fillPeriod, movingScene, moveByMode, multiplied, pace, quaternionOf, remarks, screwed, turnWhole, type MechanismMode, type PackedMechanismModes } from "../src/mechanismModesData";
import { near, packed } from "./helpers";

const none = packed("u32", []);
const empty = packed("f32", []);
const body = (name: string, modes: number) => ({ name, modes, lineRadius: 0.01, points: packed("f32", [0, 0, 0, 1, 0, 0]), pointShapes: modes > 0 ? packed("f32", [0, 0, 0, 0, 0, 1]) : empty, lines: packed("u32", [0, 1]), triangles: none, edges: none, labels: packed("f64", []), stress: empty, barStress: empty, roundLines: none, shapes: [] });
const mode = (over: Partial<MechanismMode> = {}): MechanismMode => ({ kind: "oscillating", frequency: 1, damping: 0.1, value: [-1, 6], grows: false, whirl: 0, text: "", reach: 2, turn: 0.5, ...over });

/** Two bodies at (1, 2, 3) and the origin; the first circles about z in the first mode, the second turns about x and bends. */
function report(over: Partial<PackedMechanismModes> = {}) {
  return decodeMechanismModes({
    format: "mimbre-mechanism-modes-1",
    title: "t",
    model: "",
    point: "steady motion",
    all: 2,
    turning: 0,
    axis: [0, 0, 1],
    place: [0, 0, 0],
    period: 0,
    size: 4,
    notes: ["a note"],
    warnings: [],
    modes: [mode(), mode({ kind: "real", value: [-2, 0] })],
    // Displacement: x = e^{iφ}, y = −i e^{iφ}: forward about z. Turn of the second: 1 about x.
    shapes: packed("f32", [1, 0, 0, 0, -1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, ...new Array(24).fill(0)]),
    amplitudes: packed("f32", [0.25, 0.5, 0, 0]),
    bodies: [body("disc", 0), body("arm", 1)],
    roads: [],
    animation: { time: packed("f64", [0]), positions: packed("f64", [1, 2, 3, 0, 0, 0]), rotations: packed("f32", [1, 0, 0, 0, 1, 0, 0, 0]), modes: packed("f32", [2]) },
    ...over,
  });
}

test("a screw keeps its hinge where it is", () => {
  // About the axis z through (3, 0, 0): the origin goes by −t × (3, 0, 0).
  for (const angle of [1e-9, 1e-3, 0.3, 2, Math.PI]) {
    const moved = screwed([0, -3 * angle, 0], [0, 0, angle]);
    near(moved, [3 - 3 * Math.cos(angle), -3 * Math.sin(angle), 0], 1e-11);
  }
  // Along the axis it is the displacement itself.
  near(screwed([0, 0, 2], [0, 0, 1.5]), [0, 0, 2]);
});

test("quaternions of rotation vectors and their products are those of three.js", () => {
  const axis = new Vector3(1, -2, 0.5).normalize();
  const q = quaternionOf(axis.clone().multiplyScalar(0.8).toArray());
  const expected = new Quaternion().setFromAxisAngle(axis, 0.8);
  near(q, [expected.w, expected.x, expected.y, expected.z], 1e-12);
  near(quaternionOf([0, 0, 1e-12]), [1, 0, 0, 5e-13], 1e-20);
  const other = new Quaternion(0.1, 0.7, -0.1, 0.7).normalize();
  const product = expected.clone().multiply(other);
  near(multiplied(q, [other.w, other.x, other.y, other.z]), [product.w, product.x, product.y, product.z], 1e-12);
});

test("a mode moves the bodies by factor · Re(x e^{iφ}), forward whirl forward", () => {
  const modes = report();
  const scene = movingScene(modes);
  const at = (phase: number) => {
    moveByMode(modes, 0, 0.5, phase, scene.animation, 0);
    return [...scene.animation.positions.subarray(0, 3)];
  };
  near(at(0), [1.5, 2, 3]);
  near(at(Math.PI / 2), [1, 2.5, 3]); // counterclockwise about z
  near(at(Math.PI), [0.5, 2, 3]);
  moveByMode(modes, 0, 0.5, 0, scene.animation, 0);
  near(scene.animation.rotations.subarray(4, 8), [Math.cos(0.25), Math.sin(0.25), 0, 0], 1e-7);
  // Amplitudes begin at those of the point: 2 + 0.5 · (0.25 cos φ − 0.5 sin φ).
  near(scene.animation.modes.subarray(0, 1), [2.125]);
  moveByMode(modes, 0, 0.5, Math.PI / 2, scene.animation, 0);
  near(scene.animation.modes.subarray(0, 1), [1.75], 1e-6);
});

test("seen from the ground everything turns about the axis, too", () => {
  const modes = report({ turning: 2, place: [1, 0, 0] });
  const scene = movingScene(modes);
  moveByMode(modes, 1, 1, 0, scene.animation, 0);
  turnWhole(modes, Math.PI / 2, scene.animation);
  near(scene.animation.positions.subarray(0, 3), [-1, 0, 3]);
  near(scene.animation.rotations.subarray(0, 4), [Math.SQRT1_2, 0, 0, Math.SQRT1_2], 1e-7);
  // The faster of both goes round as often as asked for.
  near([pace(modes.modes[0], 2, 0.5).phase, pace(modes.modes[0], 2, 0.5).spin], [Math.PI, Math.PI / 3]);
  near([pace(modes.modes[0], 12, 0.5).phase, pace(modes.modes[0], 12, 0.5).spin], [Math.PI / 2, Math.PI]);
  near([pace(modes.modes[1], 0, 0.5).phase, pace(modes.modes[1], 0, 0.5).spin], [Math.PI, 0]);
});

test("the period is behind the first instant, which is the present one", () => {
  const modes = report();
  const scene = movingScene(modes);
  const { animation } = scene;
  assert.equal(animation.time.length, 33);
  assert.equal(animation.time[32], 1);
  fillPeriod(modes, 0, 1, animation);
  near(animation.positions.subarray(0, 3), [1, 2, 3]); // untouched
  near(animation.positions.subarray(6 * 8, 6 * 8 + 3), [1, 3, 3]); // a quarter
  near(animation.positions.subarray(6 * 32, 6 * 32 + 3), [2, 2, 3]);
});

test("joints stay closed: of a double pendulum, and of a loop", () => {
  // Two links of length 1 hang from the ground; the origins of their axes are at (0, 0, 0).
  const frame = (name: string, on: number, z: number) => ({ name, body: on, position: [0, 0, z], rotation: [1, 0, 0, 0, 0, -1, 0, 1, 0], motion: empty }); // z along −y … y
  const joint = (a: number, b: number, kind = "revolute") => ({ name: `${a}`, kind, a, b, size: 0 });
  const over = (more: Partial<PackedMechanismModes> = {}) =>
    report({
      modes: [mode()],
      // The first turns by 1 about y, the second by −2, so that the hinge between them at z = −1 moves by −1 along x.
      shapes: packed("f32", [0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, -3, 0, 0, 0, 0, 0, 0, -2, 0, 0, 0, 0]),
      bodies: [body("upper", 0), body("lower", 0)],
      amplitudes: empty,
      animation: { time: packed("f64", [0]), positions: packed("f64", [0, 0, 0, 0, 0, 0]), rotations: packed("f32", [1, 0, 0, 0, 1, 0, 0, 0]), modes: empty },
      frames: [frame("ground", -1, 0), frame("top", 0, 0), frame("middle", 0, -1), frame("below", 1, -1)],
      elements: [joint(0, 1), joint(2, 3)],
      ...more,
    });
  const modes = over();
  const scene = movingScene(modes);
  const place = (on: number, z: number) => {
    const { positions, rotations } = scene.animation;
    const [w, x, y, zz] = rotations.subarray(4 * on, 4 * on + 4);
    return new Vector3(0, 0, z).applyQuaternion(new Quaternion(x, y, zz, w)).add(new Vector3(...positions.subarray(3 * on, 3 * on + 3))).toArray();
  };
  const gap = () => new Vector3(...place(0, -1)).distanceTo(new Vector3(...place(1, -1)));
  moveByMode(modes, 0, 0.4, 0, scene.animation, 0);
  const [before, first, second] = [gap(), place(0, -1), scene.animation.rotations.slice(4, 8)];
  assert.ok(before > 0.05, `${before}`);
  new ClosedJoints(modes).close(scene);
  assert.ok(gap() < 1e-6, `${gap()}`);
  near(place(0, -1), first, 1e-6);
  near(scene.animation.rotations.subarray(4, 8), [...second], 1e-6); // no angle has changed
  // A third joint holds the lower end where it is: the loop opens little.
  const loop = over({ elements: [joint(0, 1), joint(2, 3), joint(4, 5)], frames: [...[frame("ground", -1, 0), frame("top", 0, 0), frame("middle", 0, -1), frame("below", 1, -1)], frame("floor", -1, -2), frame("end", 1, -2)] });
  const looped = movingScene(loop);
  moveByMode(loop, 0, 0.1, 0, looped.animation, 0);
  new ClosedJoints(loop).close(looped);
  assert.ok(looped.animation.positions.every(Number.isFinite));
});

test("the first mode that deforms something", () => {
  assert.equal(bendingMode(report()), 0);
  assert.equal(bendingMode(report({ amplitudes: packed("f32", [0, 0, 0, 1]) })), 1);
  assert.equal(bendingMode(report({ amplitudes: packed("f32", [0, 0, 0, 0]) })), 0);
});

test("amplitudes: a share of the size, but no body turns too far", () => {
  near([drawingFactor({ reach: 2, turn: 0.5 }, 4, 0.1)], [0.2]);
  near([drawingFactor({ reach: 2, turn: 30 }, 4, 0.1)], [0.02]);
  near([drawingFactor({ reach: 0, turn: 3 }, 4, 0.1)], [0.2]);
  near([drawingFactor({ reach: 2, turn: 0 }, 0, 0.1)], [0.05]);
  near([drawingFactor({ reach: 0, turn: 0 }, 4, 0.1)], [0]);
});

test("words of modes: values, damping, remarks", () => {
  assert.equal(valueText(mode()), "−1 ± 6 i");
  assert.equal(valueText(mode({ value: [1e-10, 6] })), "± 6 i");
  assert.equal(valueText(mode({ value: [-0.5, 0] })), "−0.5");
  assert.equal(dampingText(mode({ kind: "rigid" })), "–");
  assert.deepEqual(remarks(report()), ["A note"]);
  const all = remarks(report({ all: 9, turning: 3, period: 1 }));
  assert.match(all[1], /first 2 of 9/);
  assert.equal(all.length, 3);
  assert.throws(() => report({ format: "other" }), /unknown report format/);
});

const bode = decodeBode({
  format: "mimbre-bode-1",
  title: "",
  point: "",
  notes: [],
  warnings: [],
  inputs: [{ name: "u", unit: "N" }, { name: "v", unit: "1" }],
  outputs: [{ name: "a", unit: "m" }, { name: "b", unit: "m" }, { name: "c", unit: "rad" }],
  frequencies: packed("f64", [1, 10]),
  real: packed("f64", [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]),
  imaginary: packed("f64", [0, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
});

test("a response is found by input and output", () => {
  assert.deepEqual([...responseOf(bode, 0, 1).real], [3, 4]);
  assert.deepEqual([...responseOf(bode, 1, 2).real], [11, 12]);
  assert.deepEqual(magnitudes(responseOf(bode, 0, 1)), [5, 4]);
  assert.deepEqual(decibels([10, 0, 0.1]), [20, null, -20]);
  assert.deepEqual([firstInput(bode), firstOutputs(bode, 0)], [0, [0, 1]]);
  // What does not respond is not shown at first.
  const still = { ...bode, real: new Float64Array([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1]), imaginary: new Float64Array(12) };
  assert.deepEqual([firstInput(still), firstOutputs(still, 1), firstOutputs(still, 0)], [1, [2], [0, 1]]);
});

test("phases go on over ±180°", () => {
  const angles = [-10, -100, -170, -200, -350, -370, -540];
  const response = (degrees: number[]) => ({
    real: Float64Array.from(degrees, (angle) => Math.cos((angle * Math.PI) / 180)),
    imaginary: Float64Array.from(degrees, (angle) => Math.sin((angle * Math.PI) / 180)),
  });
  near(phases(response(angles)) as number[], angles, 1e-9);
  assert.equal(phases({ real: new Float64Array([-1]), imaginary: new Float64Array([-0]) })[0], 180);
  // Where there is no response there is no phase, and it goes on behind.
  const gap = phases({ real: new Float64Array([-1, 0, -1, NaN]), imaginary: new Float64Array([0.1, 0, -0.1, 0]) });
  assert.equal(gap[1], null);
  assert.equal(gap[3], null);
  assert.ok(gap[2]! > 180);
});

test("units of responses", () => {
  assert.equal(ratioUnit("m", "N"), "m/N");
  assert.equal(ratioUnit("m", ""), "m");
  assert.equal(ratioUnit("1", "rad/s"), "1/(rad/s)");
  assert.equal(ratioUnit("N m", "N m"), "no unit");
});

test("marks of logarithmic axes and of phases", () => {
  assert.deepEqual(logarithmicTicks(0.1, 1000), [0.1, 1, 10, 100, 1000]);
  assert.deepEqual(logarithmicTicks(2e-8, 3e5), [1e-6, 1e-4, 1e-2, 1, 1e2, 1e4]);
  assert.deepEqual(logarithmicTicks(1, 40), [1, 2, 5, 10, 20]);
  assert.deepEqual(logarithmicTicks(2, 7), [2, 3, 4, 5, 6, 7]);
  assert.deepEqual(phaseTicks(-200, 10), [-180, -135, -90, -45, 0]);
  assert.deepEqual(phaseTicks(-10, 10), [-10, -5, 0, 5, 10]);
  assert.deepEqual(phaseTicks(-900, 100), [-900, -720, -540, -360, -180, 0]);
});
