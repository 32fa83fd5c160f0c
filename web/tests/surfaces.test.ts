import assert from "node:assert/strict";
import { test } from "node:test";
import { atNode, has, peak, peaks, PointValues } from "../src/coloring";
import { drape } from "../src/drape";
import { dashes, isCoupling } from "../src/couplingView";
import { decodeBody, type Animation, type Body } from "../src/data";
import { amplitudesOf, combined, decodeModes, ordered, swingScene, verdict, type PackedModes } from "../src/modesData";
import { isJointLaw, jointLawText } from "../src/jointLawView";
import { stresses, vonMises } from "../src/stress";
import { scaleFor } from "../src/engineering";
import { near, packed } from "./helpers";

/** Two points, three modes; stress of the first two modes alone. */
const plate: Body = decodeBody({
  name: "plate",
  modes: 3,
  lineRadius: 0.01,
  points: packed("f32", [0, 0, 0, 2, 0, 0]),
  pointShapes: packed("f32", [0, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 1, 0, 0, 0, 0, 0]),
  lines: packed("u32", []),
  triangles: packed("u32", []),
  edges: packed("u32", [0, 1]),
  labels: packed("f64", [11, 4503599627370496]),
  stress: packed("f32", [100, 0, 0, 0, 0, 0, 0, 0, 0, 10, 0, 0, -30, 0, 0, 0, 0, 0, 5, 5, 5, 0, 0, 0]),
  barStress: packed("f32", []),
  roundLines: packed("u32", []),
  shapes: [],
});

const animation: Animation = {
  time: new Float64Array([0, 1, 2]),
  positions: new Float64Array(9),
  rotations: new Float32Array([1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]),
  modes: new Float32Array([0, 0, 0, 2, 1, 0, NaN, 0, 9]),
  bodies: 1,
  amplitudes: 3,
};

test("von Mises' stress: uniaxial, shear, hydrostatic, and a general state turned", () => {
  const out = new Float32Array(3);
  vonMises(new Float32Array([-7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 4, 4, 4, 0, 0, 0]), out);
  near(out, [7, 2 * Math.sqrt(3), 0], 1e-6);
  // Principal stresses 9, 4, −1 turned about z by 0.7.
  const [c, s] = [Math.cos(0.7), Math.sin(0.7)];
  const turned = [9 * c * c + 4 * s * s, 9 * s * s + 4 * c * c, -1, 5 * s * c, 0, 0];
  const one = new Float32Array(1);
  vonMises(new Float32Array(turned), one);
  near(one, [Math.sqrt((5 ** 2 + 5 ** 2 + 10 ** 2) / 2)], 1e-5);
});

test("stresses are sums over the modes that have them", () => {
  const out = new Float32Array(12);
  stresses(plate, [2, 1, 1000], out);
  near(out, [170, 0, 0, 0, 0, 0, 5, 5, 5, 20, 0, 0]);
  stresses({ ...plate, stress: new Float32Array() }, [1, 1, 1], out);
  near(out, new Array(12).fill(0));
});

test("von Mises' stress of bars: bending of circles and rectangles, shear, the larger of two bars at a point", () => {
  // A round bar, then a rectangular one; the second mode twists the first bar's end alone.
  const modes = [5, 3, 4, 0, -5, 3, -4, 0, 1, 6, -7, 0, -2, 0, 0, 0, ...new Array(7).fill(0), 10, ...new Array(8).fill(0)];
  const frame: Body = {
    ...plate,
    points: new Float32Array(9),
    lines: new Uint32Array([0, 1, 1, 2]),
    stress: new Float32Array(),
    barStress: new Float32Array(modes),
    roundLines: new Uint32Array([1, 0]),
  };
  assert.equal(has(frame, "stress"), true);
  near(new PointValues(frame, "stress").at([1, 0, 9]), [10, 14, 2], 1e-5);
  near(new PointValues(frame, "stress").at([-2, 0, 9]), [20, 28, 4], 1e-5);
  near(new PointValues(frame, "stress").at([1, 2, 9]), [10, Math.hypot(10, 20), 2], 1e-5);
  assert.deepEqual(peaks([frame], animation, "stress")[0], { value: 28, point: 1, time: 1 });
});

test("a dashed line has so many dashes, from end to end", () => {
  const geometry = dashes(3);
  const position = geometry.getAttribute("position");
  const heights = [...new Set(Array.from(geometry.getIndex()!.array, (corner) => Math.round(5 * position.getY(corner))))].sort();
  assert.deepEqual(heights, [0, 1, 2, 3, 4, 5]);
  const middles = new Set<number>();
  const index = Array.from(geometry.getIndex()!.array);
  for (let k = 0; k < index.length; k += 3) middles.add(Math.min(...index.slice(k, k + 3).map((corner) => Math.round(5 * position.getY(corner)))));
  assert.deepEqual([...middles].sort(), [0, 2, 4]);
});

test("what drives or brakes a joint is told from its springs", () => {
  assert.deepEqual(["motor about z", "friction along x", "stop about y", "motor", "torsional spring about z"].map(isJointLaw), [true, true, true, false, false]);
  assert.equal(jointLawText("friction along x"), "friction of the joint");
  assert.deepEqual(["coupling", "coupling spring", "parallel", "perpendicular", "distance", "spring"].map(isCoupling), [true, true, true, true, false, false]);
});

test("values and their largest over the time", () => {
  near(new PointValues(plate, "stress").at([2, 1, 0]), [170, 20 * Math.sqrt(3)], 1e-4);
  near(new PointValues(plate, "displacement").at([2, 1, 5]), [5, Math.hypot(6, 4)], 1e-6);
  const [stress] = peaks([plate], animation, "stress");
  assert.deepEqual(stress, { value: 170, point: 0, time: 1 });
  const [moved] = peaks([plate], animation, "displacement");
  assert.deepEqual([moved.point, moved.time], [1, 1]);
  assert.deepEqual(peaks([{ ...plate, stress: new Float32Array() }], animation, "stress"), [{ value: 0, point: -1, time: 0 }]);
  assert.equal(peak([NaN, 1, 3, 2]), 2);
  assert.equal(peak([NaN]), -1);
  assert.equal(has(plate, "stress"), true);
  assert.equal(has(plate, "none"), false);
  assert.equal(atNode(plate, 1), " at node 4503599627370496");
  assert.equal(atNode({ ...plate, labels: new Float64Array() }, 1), "");
});

test("units keep numbers short", () => {
  assert.deepEqual(scaleFor("Pa", 2.5e8), { unit: "MPa", size: 1e6 });
  assert.deepEqual(scaleFor("m", 0.002), { unit: "mm", size: 1e-3 });
  assert.deepEqual(scaleFor("Pa", 0), { unit: "Pa", size: 1 });
});

const empty = packed("f32", []);
const body = { name: "arm", modes: 2, lineRadius: 1, points: empty, pointShapes: empty, lines: packed("u32", []), triangles: packed("u32", []), edges: packed("u32", []), labels: packed("f64", []), stress: empty, barStress: empty, roundLines: packed("u32", []), shapes: [] };
const modes: PackedModes = {
  format: "mimbre-modes-1",
  name: "arm",
  checks: [{ name: "mass", passed: true, detail: "" }, { name: "units", passed: false, detail: "375 m" }],
  mass: 2,
  centre: [0, 0, 0],
  inertia: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  frames: [{ name: "ball", position: [1, 0, 0], rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], shapes: packed("f32", [1, 0, 0, 0, 2, 0]), turns: packed("f32", [0, 0, 0, 0, 0, 0.5]) }],
  families: [
    { name: "eigenmodes", modes: [{ name: "1", frequency: 3 }, { name: "2", frequency: null }], amplitudes: packed("f32", [1, 0, 0, 1]) },
    { name: "user's", modes: [{ name: "a", frequency: 3 }, { name: "b", frequency: 4 }], amplitudes: packed("f32", [2, -1, 0.5, 4]) },
  ],
  body,
};

test("a body's page is decoded, its modes swing", () => {
  const report = decodeModes(modes);
  near(amplitudesOf(report, 1, 1), [0.5, 4]);
  near(combined(report.frames[0].shapes, [3, -1]), [3, -2, 0]);
  near(combined(report.frames[0].turns, [3, -1]), [0, 0, -0.5]);
  const { animation: swinging } = swingScene(report.body, amplitudesOf(report, 1, 0));
  near(swinging.modes, [-2, 1, 2, -1]);
  assert.throws(() => decodeModes({ ...modes, format: "mimbre-report-1" }), /unknown report format/);
});

test("the verdict names what failed, failed checks come first", () => {
  assert.deepEqual(verdict(modes.checks), { text: "1 of 2 checks of the reduction failed: units.", passed: false });
  assert.equal(verdict([modes.checks[0]]).passed, true);
  assert.equal(verdict([]).passed, false);
  assert.deepEqual(ordered(modes.checks).map(({ name }) => name), ["units", "mass"]);
});

test("what is painted on the ground covers just the part that is asked for, at the ground's height", () => {
  // A roof of two slopes, z = 1 − |x|, from −1 to 1 along x and 0 to 2 along y.
  const points = [-1, 0, 0, 0, 0, 1, 1, 0, 0, -1, 2, 0, 0, 2, 1, 1, 2, 0];
  const triangles = [0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4];
  const covered = drape(points, triangles, [-0.5, 0.25], [0.3, 1.1]);
  let area = 0; // seen from above
  for (let k = 0; k < covered.length; k += 9) {
    const [ax, ay, , bx, by, , cx, cy] = covered.slice(k, k + 9);
    area += 0.5 * Math.abs((bx - ax) * (cy - ay) - (cx - ax) * (by - ay));
  }
  near([area], [0.75 * 0.8]);
  for (let k = 0; k < covered.length; k += 3) {
    const [x, y, z] = covered.slice(k, k + 3);
    assert.ok(x >= -0.5 && x <= 0.25 && y >= 0.3 && y <= 1.1);
    near([z], [1 - Math.abs(x)]);
  }
  assert.deepEqual(drape(points, triangles, [1, 2], [0, 2]), []);
  assert.equal(drape(points, triangles, [-9, 9], [-9, 9]).length, 9 * 4);
});
