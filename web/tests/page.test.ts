import assert from "node:assert/strict";
import { test } from "node:test";
import { DoubleSide, Mesh, MeshBasicMaterial, Raycaster, Vector3 } from "three";
import { turbo } from "../src/color";
import { decodeArray, decodeReport, type Animation, type Body, type PackedReport } from "../src/data";
import { peaks } from "../src/coloring";
import { deformed, displacements, magnitudes } from "../src/deform";
import { flatten, formatNumber, formatWithin, splitKey } from "../src/format";
import { firstSelection, grouped, groupOf } from "../src/groups";
import { amplitudesAt, locate, nearest, poseAt, slerp, type Quaternion } from "../src/interpolate";
import { LandView, stretch } from "../src/landView";
import { crossings, finiteProfile, niceLength } from "../src/surroundings";
import { near, packed } from "./helpers";

/** A beam of three points along x with two modes: the tip rises, the middle goes sideways. */
const beam: Body = {
  name: "beam",
  firstMode: 1,
  modes: 2,
  lineRadius: 0.01,
  points: new Float32Array([0, 0, 0, 1, 0, 0, 2, 0, 0]),
  pointShapes: new Float32Array([0, 0, 0, 0, 0, 0.25, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0]),
  lines: new Uint32Array([0, 1, 1, 2]),
  triangles: new Uint32Array(),
  edges: new Uint32Array(),
  labels: new Float64Array(),
  stress: new Float32Array(),
  barStress: new Float32Array(),
  roundLines: new Uint32Array(),
  shapes: [],
};

/** Two bodies; the second turns by 90° about z in 1 s. Amplitudes: one of another body, two of the beam. */
const half = Math.SQRT1_2;
const animation: Animation = {
  time: new Float64Array([0, 1]),
  positions: new Float64Array([0, 0, 0, 1e6, 2, 3, 0, 0, 0, 1e6 + 1, 2, 5]),
  rotations: new Float32Array([1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, half, 0, 0, half]),
  modes: new Float32Array([9, 0, 0, 9, 2, -4]),
  bodies: 2,
  amplitudes: 3,
};

test("arrays are decoded to their last bit", () => {
  const values = [0, -1.5, 1e300, 1 / 3, NaN, -Infinity];
  assert.deepEqual([...decodeArray(packed("f64", values))], values);
  assert.deepEqual([...decodeArray(packed("f32", [0.5, -2]))], [0.5, -2]);
  assert.deepEqual([...decodeArray(packed("u32", [0, 4294967295]))], [0, 4294967295]);
  assert.throws(() => decodeArray({ ...packed("f32", [1, 2]), size: 3 }), /damaged array: 8 bytes for 3 f32/);
});

test("a report is decoded: offsets, gaps, places of the modes", () => {
  const empty = packed("f32", []);
  const none = packed("u32", []);
  const body = { lineRadius: 1, points: empty, pointShapes: empty, lines: none, triangles: none, edges: none, labels: packed("f64", []), stress: empty, barStress: empty, roundLines: none, shapes: [] };
  const report = decodeReport({
    format: "mimbre-report-1",
    title: "t",
    step: 0.01,
    instants: 3,
    model: "",
    options: null,
    summary: null,
    time: packed("f64", [0, 1, 2]),
    channels: [
      { name: "a", unit: "m", meaning: "", offset: 1e6 },
      { name: "b", unit: "m", meaning: "", offset: 0 },
    ],
    values: packed("f32", [-0.5, 0, 0.5, 1, NaN, 3]),
    shown: [],
    bodies: [{ ...body, name: "p", modes: 2 }, { ...body, name: "q", modes: 3 }],
    roads: [],
    animation: { time: packed("f64", []), positions: packed("f64", []), rotations: empty, modes: empty },
  } as PackedReport);
  assert.deepEqual(report.channels[0].values, [999999.5, 1000000, 1000000.5]);
  assert.equal(report.channels[0].range, 1);
  assert.deepEqual(report.channels[1].values, [1, null, 3]);
  assert.deepEqual(report.bodies.map((b) => b.firstMode), [0, 2]);
  assert.equal(report.animation.amplitudes, 5);
  assert.throws(() => decodeReport({ format: "other" } as PackedReport), /unknown report format other/);
});

test("times are located between instants", () => {
  const time = [0, 1, 3];
  assert.deepEqual(locate(time, -1), { index: 0, fraction: 0 });
  assert.deepEqual(locate(time, 0.25), { index: 0, fraction: 0.25 });
  assert.deepEqual(locate(time, 2), { index: 1, fraction: 0.5 });
  assert.deepEqual(locate(time, 9), { index: 1, fraction: 1 });
  assert.deepEqual(locate([5], 7), { index: 0, fraction: 0 });
  assert.deepEqual(locate([], 7), { index: 0, fraction: 0 });
  assert.equal(nearest(time, 2.5), 2);
  assert.equal(nearest(time, 1.5), 1);
});

test("slerp turns at constant rate along the shorter way", () => {
  const about = (angle: number): Quaternion => [Math.cos(angle / 2), 0, Math.sin(angle / 2), 0];
  for (const fraction of [0, 0.2, 0.5, 1]) {
    near(slerp(about(0.3), about(1.7), fraction), about(0.3 + 1.4 * fraction));
    const opposite = about(1.7).map((part) => -part) as Quaternion; // the same rotation
    near(slerp(about(0.3), opposite, fraction), about(0.3 + 1.4 * fraction));
  }
  near(slerp(about(1), about(1), 0.5), about(1));
  near(slerp(about(1), about(1 + 1e-7), 0.5), about(1 + 5e-8));
});

test("poses and amplitudes are interpolated", () => {
  const { position, rotation } = poseAt(animation, 0.5, 1);
  near(position, [1e6 + 0.5, 2, 4]);
  near(rotation, [Math.cos(Math.PI / 8), 0, 0, Math.sin(Math.PI / 8)], 1e-7);
  near(amplitudesAt(animation, 0.25, beam.firstMode, beam.modes), [0.5, -1]);
  near(poseAt(animation, 7, 0).position, [0, 0, 0]);
  const broken = { ...animation, positions: animation.positions.map((value, k) => (k < 6 ? value : NaN)) };
  near(poseAt(broken, 0, 1).position, [1e6, 2, 3]);
});

test("points are displaced by exaggeration times shapes times amplitudes", () => {
  const u = new Float32Array(9);
  displacements(beam, [2, -4], u);
  near(u, [0, 0, 0, 0, -4, 0.5, 0, 0, 2]);
  const points = new Float32Array(9);
  deformed(beam, u, 10, points);
  near(points, [0, 0, 0, 1, -40, 5, 2, 0, 20]);
  const lengths = new Float32Array(3);
  magnitudes(u, lengths);
  near(lengths, [0, Math.hypot(4, 0.5), 2], 1e-6);
  const [largest] = peaks([beam], animation, "displacement");
  assert.ok(Math.abs(largest.value - Math.hypot(4, 0.5)) < 1e-6);
  assert.deepEqual([largest.point, largest.time], [1, 1]);
  assert.equal(peaks([{ ...beam, pointShapes: new Float32Array() }], animation, "displacement")[0].value, 0);
});

test("numbers are short and keep their digits", () => {
  assert.equal(formatNumber(0), "0");
  assert.equal(formatNumber(-0.5), "−0.5");
  assert.equal(formatNumber(3.14159265), "3.1416");
  assert.equal(formatNumber(12345678), "12\u202f345\u202f678");
  assert.equal(formatNumber(1.5e-7), "1.5·10⁻⁷");
  assert.equal(formatNumber(NaN), "not a number");
  assert.equal(formatWithin(1, -2e-15), "0");
  assert.equal(formatWithin(8, 1.23456789), "1.2346");
  assert.equal(formatWithin(0, 1.5), "1.5");
});

test("the summary is flattened, warnings are marked", () => {
  assert.deepEqual(splitKey("cpu_s"), { label: "Cpu", unit: "s" });
  assert.deepEqual(splitKey("real_time_factor"), { label: "Real time factor", unit: "" });
  assert.deepEqual(
    flatten({ step: { mean_us: 12.5, late: false }, warnings: ["too large"], warning_count: 0, sizes: [1, 2] }),
    [
      { label: "Step · Mean", value: "12.5 µs", warning: false },
      { label: "Step · Late", value: "no", warning: false },
      { label: "Warnings", value: "too large", warning: true },
      { label: "Warning count", value: "0", warning: false },
      { label: "Sizes", value: "1, 2", warning: false },
    ],
  );
  const warned = (summary: unknown) => flatten(summary).map((line) => line.warning);
  assert.deepEqual(warned({ status: "ok", steps: 3 }), [false, false]);
  assert.deepEqual(warned({ status: "failed", message: "did not converge", steps: 3 }), [true, true, false]);
});

test("channels are grouped, searched and chosen", () => {
  const channel = (name: string, unit: string) => ({ name, unit, meaning: "", values: [], range: 0 });
  const channels = [channel("car.z", "m"), channel("car.pitch", "rad"), channel("tip", "m"), channel("car.v", "m/s"), channel("n", "1")];
  assert.equal(groupOf(channels[2], "name"), "general");
  assert.deepEqual([...grouped(channels, "name", "")], [["car", [0, 1, 3]], ["general", [2, 4]]]);
  assert.deepEqual([...grouped(channels, "unit", "car m")], [["m", [0]], ["m/s", [3]]]);
  assert.deepEqual(firstSelection(channels, 1, 2), [0, 1]);
  assert.deepEqual(firstSelection(channels), [0, 1, 2, 3]);
  const standard = [channel("joint.pin.position", "rad"), channel("energy.kinetic", "J")];
  assert.deepEqual(firstSelection([...standard, channels[0]]), [2]);
  assert.deepEqual(firstSelection(standard), [0, 1]);
});

test("colours, grids and profiles", () => {
  near(turbo(-1), [0x46 / 255, 0x62 / 255, 0xd7 / 255]);
  near(turbo(1), [0xcb / 255, 0x2a / 255, 0x04 / 255]);
  assert.equal(niceLength(0.7), 0.5);
  assert.equal(niceLength(3), 2);
  assert.equal(niceLength(10), 10);
  assert.deepEqual(crossings([0.5, 1], [2.5, 5], 1), [[1, 2], [2, 4]]);
  assert.deepEqual(crossings([3, 0], [3, 1], 1), []);
  assert.deepEqual(stretch([[0, 0], [2, 4], [3, 4]], 1, 2.5), [[1, 2], [2, 4], [2.5, 4]]);
  assert.deepEqual(stretch([[0, 0], [2, 4], [3, 4]], 2, 9), [[2, 4], [3, 4]]);
  assert.deepEqual(stretch([[0, 0], [2, 4]], 3, 4), []);
  assert.deepEqual(finiteProfile(new Float64Array([0, 1, NaN, 2, 3, 4])), [[0, 1], [3, 4]]);
});

test("the land lies about the road as high as its profile, moves along sideways, and is drawn as far as one sees", () => {
  const material = new MeshBasicMaterial({ side: DoubleSide });
  const materials = { surface: material, border: material, mark: material, land: material, line: material, patch: material };
  const origin = new Vector3(10, 0, 0.5);
  const patch = { x: [50, 60] as [number, number], y: [-100, 0] as [number, number], friction: 0.2 };
  const land = new LandView([[0, 0], [100, 0], [200, 10]], [patch], origin, 1, 120, 2, materials);
  const heightAt = (x: number, y: number) => {
    land.group.updateMatrixWorld(true);
    const ray = new Raycaster(new Vector3(x - origin.x, y - origin.y, 100), new Vector3(0, 0, -1));
    const hits = ray.intersectObjects(land.group.children.filter(({ visible }) => visible)).filter(({ object }) => object instanceof Mesh);
    return hits.map(({ point }) => point.z + origin.z);
  };
  land.look(new Vector3(40.3 - origin.x, 0, 0), 1000);
  for (const [x, y, z, surfaces] of [[30.3, 50.2, 0, 1], [30.3, 1.2, 0, 2], [55.3, -1.2, 0, 3], [55.3, 1.2, 0, 2], [55.3, -50.2, 0, 2], [150.3, -50.2, 5.03, 1]]) {
    const heights = heightAt(x, y);
    near(heights, Array.from({ length: surfaces }, () => z), 1e-4);
  }
  assert.equal(heightAt(30.3, 200).length, 0);
  land.look(new Vector3(40.3 - origin.x, 180.3, 0), 30);
  near(heightAt(30.3, 200.2), [0], 1e-4);
  assert.equal(heightAt(150.3, 180).length, 0);
});
