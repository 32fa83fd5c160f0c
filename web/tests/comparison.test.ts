import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeComparison, type PackedComparison, type Run } from "../src/comparisonData";
import { valueAt } from "../src/interpolate";
import { extent, overlayRange } from "../src/overlayRange";
import { isSound, remarks, runTable } from "../src/runFacts";
import { packed } from "./helpers";

const empty = packed("f32", []);
const head = { file: "", title: "", step: 0.01, instants: 2, model: "", options: null, summary: null };
const scene = { bodies: [], roads: [], animation: { time: packed("f64", []), positions: packed("f64", []), rotations: empty, modes: empty } };

function run(label: string, time: number[], summary: unknown): Run {
  return { ...head, label, file: `${label}.h5`, time, commonTime: [], summary };
}

test("a comparison is decoded: every run has its own channels and times", () => {
  const { runs, channels } = decodeComparison({
    format: "mimbre-comparison-1",
    runs: [
      { ...head, label: "a", time: packed("f64", [0, 1]), values: packed("f32", [1, 2]), commonTime: packed("f64", []), differences: empty },
      { ...head, label: "b", time: packed("f64", [0, 1, 2]), values: packed("f32", [3, NaN, 5, 6, 7, 8]), commonTime: packed("f64", [0, 1]), differences: packed("f32", [-1, 1]) },
      { ...head, label: "c", time: packed("f64", [4]), values: packed("f32", [9]), commonTime: packed("f64", []), differences: empty },
    ],
    channels: [
      { name: "x", unit: "m", meaning: "", curves: [{ run: 0, offset: 0 }, { run: 1, offset: 10 }], deviations: [{ run: 1, offset: 3, mean: 0.5, largest: 2, at: 1, amplitude: 2 }] },
      { name: "y", unit: "m", meaning: "", curves: [{ run: 1, offset: 0 }, { run: 2, offset: 0 }], deviations: [] },
    ],
    shown: [],
    ...scene,
  } as unknown as PackedComparison);
  assert.deepEqual(runs.map((r) => r.time), [[0, 1], [0, 1, 2], [4]]);
  assert.deepEqual(channels[0].curves.map((curve) => curve?.values), [[1, 2], [13, null, 15], undefined]);
  assert.deepEqual(channels[0].differences.map((curve) => curve?.values), [undefined, [2, 4], undefined]);
  assert.deepEqual(channels[0].deviations, [null, { mean: 0.5, largest: 2, at: 1, amplitude: 2 }, null]);
  assert.deepEqual(channels[1].curves.map((curve) => curve?.values), [undefined, [6, 7, 8], [9]]);
  assert.deepEqual(channels[1].differences, [null, null, null]);
  assert.throws(() => decodeComparison({ format: "mimbre-report-1" } as PackedComparison), /unknown report format/);
});

test("curves are read between their instants, not beyond them", () => {
  const time = [0, 1, 3];
  assert.equal(valueAt(time, [0, 2, 4], 0.5), 1);
  assert.equal(valueAt(time, [0, 2, 4], 2), 3);
  assert.equal(valueAt(time, [0, 2, 4], 3), 4);
  assert.equal(valueAt(time, [0, 2, null], 1), 2);
  assert.equal(valueAt(time, [0, 2, null], 2), null);
  assert.equal(valueAt(time, [0, 2, 4], 3.5), null);
  assert.equal(valueAt(time, [0, 2, 4], -1), null);
  assert.equal(valueAt([], [], 0), null);
});

test("a run that failed does not flatten the sound ones", () => {
  assert.deepEqual(extent([5, null, undefined, -1, 9], 0, 3), [-1, 5]);
  assert.equal(extent([null, 1], 0, 0), null);
  assert.deepEqual(overlayRange([[0, 2], [1, 4]], []), [0, 4]);
  assert.deepEqual(overlayRange([[0, 4]], [[1, 1e6]]), [0, 6]);
  assert.deepEqual(overlayRange([[0, 4]], [[-1, 3]]), [-1, 4]);
  assert.deepEqual(overlayRange([[1, 1]], [[0, 3]]), [0, 3]);
  assert.deepEqual(overlayRange([], [[0, 1e6]]), [0, 1e6]);
  assert.equal(overlayRange([], []), null);
});

test("early ends are told", () => {
  const runs = [
    run("whole", [0, 20], { status: "ok" }),
    run("rounded", [0, 20 - 1e-12], { status: "ok" }),
    run("shorter", [0, 10], { status: "ok" }),
    run("linear", [0, 12.62], { status: "failed", message: "the step to t = 12.63 s did not converge" }),
    run("killed", [0, 3], null),
    run("empty", [], null),
  ];
  assert.deepEqual(runs.map(isSound), [true, true, true, false, false, false]);
  assert.deepEqual(remarks(runs), [
    { text: "shorter ends earlier, drawn up to 10 s.", warning: false },
    { text: "linear failed, drawn up to 12.62 s: the step to t = 12.63 s did not converge", warning: true },
    { text: "killed was cut short, drawn up to 3 s", warning: true },
    { text: "empty contains no instants.", warning: true },
  ]);
});

test("the table of runs has the columns of which something is known", () => {
  const plain = runTable([run("a", [0, 1], { coordinates: 7, integrator: "generalized_alpha", formulation: "relative" }), run("b", [0], null)]);
  assert.deepEqual(plain.titles, ["Coordinates", "Step", "End", "Method", "File"]);
  assert.deepEqual(plain.rows, [["7", "10 ms", "1 s", "relative, generalized alpha", "a.h5"], ["–", "10 ms", "0 s", "–", "b.h5"]]);
  const measured = runTable([run("a", [0, 1], { cpu_seconds: 0.015432, real_time_factor: 1296.2 })]);
  assert.deepEqual(measured.titles, ["CPU time", "Real-time factor", "Step", "End", "File"]);
  assert.deepEqual(measured.rows[0].slice(0, 2), ["0.0154 s", "1300"]);
});
