import assert from "node:assert/strict";
import { test } from "node:test";
import { niceAbove } from "../src/arrows";
import { csv, field } from "../src/csv";
import { speeds } from "../src/clock";
import { axisScale, onSecondAxis, scaleFor, tickLabels, timeText } from "../src/engineering";
import { evaluate, type Source } from "../src/formula";
import { spectrum, telling, transform } from "../src/spectrum";
import { statistics } from "../src/statistics";
import { quantity, summaryLines, warningsOf } from "../src/summaryLines";
import type { Trace } from "../src/trace";
import { near } from "./helpers";

const times = (count: number, step: number) => Array.from({ length: count }, (_, i) => i * step);

test("axes speak of kN, MPa, mm and degrees", () => {
  assert.deepEqual(scaleFor("N", 3.2e6), { unit: "MN", size: 1e6 });
  assert.deepEqual(scaleFor("Pa", 2.5e8), { unit: "MPa", size: 1e6 });
  assert.deepEqual(scaleFor("m", 0.02), { unit: "mm", size: 1e-3 });
  assert.deepEqual(scaleFor("m", 1200), { unit: "m", size: 1 });
  assert.equal(scaleFor("rad", 1).unit, "°");
  assert.equal(scaleFor("rad", 1).size * 180, Math.PI);
  assert.deepEqual(scaleFor("N", 0), { unit: "N", size: 1 });
  assert.deepEqual(scaleFor("furlong", 1e9), { unit: "furlong", size: 1 });
});

test("things of a micrometre and of kilometres are told in their units", () => {
  assert.equal(scaleFor("m", 3e-8).unit, "nm");
  assert.equal(scaleFor("m", 2e-6).unit, "µm");
  assert.deepEqual(scaleFor("m", 12000), { unit: "km", size: 1e3 });
  assert.equal(scaleFor("N", 2e-5).unit, "µN");
  assert.equal(scaleFor("N m", 4e-9).unit, "nN m");
  assert.equal(scaleFor("J", 1e-13).unit, "pJ");
  assert.deepEqual(scaleFor("m", 9e-15), { unit: "m", size: 1 }); // round-off
});

test("times are told in the unit of their axis, as finely as the instants lie", () => {
  assert.equal(axisScale("s", 0.5).unit, "s");
  assert.equal(axisScale("s", 0.003).unit, "ms");
  assert.equal(axisScale("Hz", 2500).unit, "Hz");
  assert.equal(axisScale("Hz", 5e4).unit, "kHz");
  assert.equal(timeText(0, 8, 801)(5.2), "5.200 s");
  assert.equal(timeText(0, 0.5, 2501)(0.181), "0.1810 s");
  assert.equal(timeText(0, 3e-3, 301)(1.23e-3), "1.23 ms");
  assert.equal(timeText(0, 3600, 101)(60), "60.000 s");
  assert.equal(timeText(0, 0, 1)(0), "0.000 s");
});

test("a run of any length can be watched", () => {
  for (const duration of [1e-6, 3e-3, 0.5, 8, 3600, 1e6]) {
    const [slowest, fastest, start] = speeds(duration);
    assert.ok(slowest <= start && start <= fastest);
    const lasts = duration / start;
    assert.ok((lasts >= 0.5 || start === 1) && (lasts <= 600 || start === 1), `${duration} s lasts ${lasts} s`);
  }
  assert.deepEqual(speeds(8), [0.1, 4, 1]);
});

test("the labels of an axis are whole and told apart", () => {
  assert.deepEqual(tickLabels([-200000, 0, 200000]), ["−200\u202f000", "0", "200\u202f000"]);
  assert.deepEqual(tickLabels([0.1, 0.2, 0.3]), ["0.1", "0.2", "0.3"]);
  assert.deepEqual(tickLabels([-1, -0.75, -0.5, -0.25, 0]), ["−1.00", "−0.75", "−0.50", "−0.25", "0.00"]);
  assert.deepEqual(tickLabels([0, 2.5, 5]), ["0.0", "2.5", "5.0"]);
  assert.deepEqual(tickLabels([0.6, 0.8, 1]), ["0.6", "0.8", "1.0"]);
  assert.deepEqual(tickLabels([100000.001, 100000.002]), ["100\u202f000.001", "100\u202f000.002"]);
  assert.deepEqual(tickLabels([-1e-17, 0.5]), ["0.0", "0.5"]);
  assert.equal(new Set(tickLabels([1e9, 1.1e9])).size, 2);
});

test("curves much smaller than others go to the second axis", () => {
  assert.deepEqual(onSecondAxis([1000, 800, 2, 3]), [false, false, true, true]);
  assert.deepEqual(onSecondAxis([1, 2, 5, 0]), [false, false, false, false]);
  assert.deepEqual(onSecondAxis([1, 1e-9, 0.01]), [false, false, true]); // round-off is not worth an axis
  assert.deepEqual(onSecondAxis([]), []);
});

test("scales of arrows are round and not too short", () => {
  assert.equal(niceAbove(1200), 2000);
  assert.equal(niceAbove(5), 5);
  assert.equal(niceAbove(0.07), 0.1);
  assert.equal(niceAbove(0), 0);
});

test("statistics of a sine over whole periods, of stretches, and with gaps", () => {
  const time = times(1001, 0.001);
  const values = time.map((t) => 3 + 2 * Math.sin(2 * Math.PI * 5 * t));
  const found = statistics(time, values)!;
  near([found.min, found.minAt, found.max, found.maxAt], [1, 0.15, 5, 0.05], 1e-12);
  near([found.mean, found.rms], [3, Math.sqrt(9 + 2)], 1e-3);
  // A straight line's mean square is exact.
  near([statistics([0, 3], [0, 3])!.rms], [Math.sqrt(3)]);
  assert.equal(statistics(time, values, 2, 3), null);
  const gap = statistics([0, 1, 2, 3], [1, null, 5, 5])!;
  assert.equal(gap.mean, 5);
  assert.deepEqual(statistics([1], [-4]), { min: -4, minAt: 1, max: -4, maxAt: 1, mean: -4, rms: 4 });
});

test("the transform is the sum that defines it", () => {
  const x = [1, -2, 0.5, 3, 0, 4, -1, 2];
  const re = Float64Array.from(x);
  const im = new Float64Array(8);
  transform(re, im);
  for (let m = 0; m < 8; ++m) {
    let [a, b] = [0, 0];
    x.forEach((value, k) => ((a += value * Math.cos((2 * Math.PI * k * m) / 8)), (b -= value * Math.sin((2 * Math.PI * k * m) / 8))));
    near([re[m], im[m]], [a, b], 1e-12);
  }
});

test("a spectrum shows a sine's amplitude at its frequency with every window", () => {
  const time = times(2001, 0.0007);
  const values = time.map((t) => 7 + 0.25 * Math.sin(2 * Math.PI * 31.7 * t + 1));
  for (const window of ["hann", "flat top", "none"] as const) {
    const { frequency, amplitude } = spectrum(time, values, window);
    const peak = amplitude.indexOf(Math.max(...amplitude));
    near([frequency[peak]], [31.7], 0.4);
    near([amplitude[peak]], [0.25], window === "none" ? 0.02 : 0.01);
    near([frequency[frequency.length - 1]], [0.5 / 0.0007], 1e-6);
  }
  near([telling({ frequency: [0, 10, 20, 30, 40, 50], amplitude: [0, 1, 0.5, 0.001, 0, 0] })], [30]);
  near([telling({ frequency: [0, 10, 20], amplitude: [0, 0, 0] })], [20]);
  assert.deepEqual(spectrum(time, values, "hann", 0, 0.001).frequency, []);
  assert.deepEqual(spectrum([...time, 2], [...values, null], "hann").frequency, []);
});

const channels: Record<string, { values: (number | null)[]; unit: string }> = {
  "tip.z": { values: [1, 2, null], unit: "m" },
  "arm.z": { values: [10, 20, 30], unit: "m" },
  "a-b c": { values: [5, 6, 7], unit: "N" },
  sin: { values: [1, 1, 1], unit: "1" },
};
const source: Source = { time: [0, 1, 3], channel: (name) => (Object.keys(channels).includes(name) ? channels[name] : null) };

test("formulas: precedence, functions, units, gaps", () => {
  const values = (text: string) => evaluate(text, source).values;
  assert.deepEqual(evaluate("tip.z - 2*arm.z", source), { values: [-19, -38, null], unit: "m" });
  near(values("2+3*4^2/-(1+1)") as number[], [-22, -22, -22]);
  near(values("-2^2") as number[], [-4, -4, -4]);
  near(values("2^3^2") as number[], [512, 512, 512]);
  near(values("1e-3*.5") as number[], [5e-4, 5e-4, 5e-4]);
  assert.deepEqual(evaluate("`a-b c`/2", source), { values: [2.5, 3, 3.5], unit: "N" });
  near(values("atan2(1, 1) + max(1, pi)") as number[], Array(3).fill(Math.PI / 4 + Math.PI));
  near(values("t^2") as number[], [0, 1, 9]);
  assert.equal(evaluate("arm.z/tip.z", source).unit, "1");
  assert.equal(evaluate("arm.z*tip.z", source).unit, "");
  assert.deepEqual(values("1/(arm.z - 10)"), [null, 0.1, 0.05]);
  assert.deepEqual(values("sin + sin(0)"), [1, 1, 1]);
  assert.deepEqual(evaluate("ddt(arm.z)", source), { values: [10, 20 / 3, 5], unit: "m/s" });
  assert.deepEqual(values("int(arm.z)"), [0, 15, 65]);
});

test("a formula's mistake is reported, and nothing is run", () => {
  const wrong = (text: string, message: RegExp) => assert.throws(() => evaluate(text, source), message);
  wrong("tip.z +", /a value is missing at the end/);
  wrong("(1", /'\)' is missing/);
  wrong("nope*2", /there is no channel 'nope'/);
  wrong("alert(1)", /there is no function 'alert'/);
  wrong("constructor(1)", /there is no function 'constructor'/);
  wrong("toString", /there is no channel 'toString'/);
  wrong("1 2", /'2' is not expected \(character 3\)/);
  wrong("min(1)", /'min' takes 2 values, not 1/);
  wrong("[].x", /'\[' is not expected/);
  wrong("(".repeat(2000), /at most 1000 characters/);
});

test("CSV: instants of all curves, units in the heads, no formulas for spreadsheets", () => {
  const trace = (label: string, unit: string, time: number[], values: (number | null)[]) => ({ label, unit, time, values }) as Trace;
  const text = csv([trace("z", "m", [0, 0.1, 0.2], [1, null, 3]), trace("=HYPERLINK(1)", "1", [0, 0.2, 0.3], [4, 5, 6])], 0, 0.25);
  assert.equal(text, `t [s],z [m],"'=HYPERLINK(1)"\r\n0,1,4\r\n0.1,,\r\n0.2,3,5\r\n`);
  assert.equal(field('a,"b"'), '"a,""b"""');
});

test("the summary is a dozen lines with units", () => {
  const summary = {
    status: "ok",
    steps: 4000,
    step: 0.002,
    formulation: "relative",
    formalism: "index3",
    integrator: "generalized_alpha",
    rho: 0.9,
    coordinates: 98,
    iterations_per_step: 2.98,
    repeated_steps: 3,
    unconverged_steps: 7,
    max_position_violation: 1.2e-12,
    max_angle_violation: 2.5e-10,
    max_velocity_violation: 3e-9,
    energy: { kinetic: 12345, elastic: 0.5, numerical: -0.002 },
    validity: [{ body: "arm", deflection: 0.02, high_modes: null, time: { deflection: 1.5 } }, { body: "rod", deflection: 0.01, foreshortening: 0.03, time: {} }],
    warnings: [],
    cpu_seconds: 1.25,
    real_time_factor: 6.4,
    outputs: { a: 1 },
  };
  const lines = summaryLines(summary, { end: 8, step: 0.002, instants: 4001, bodies: 17, joints: 24 });
  assert.equal(lines.length, 12);
  const text = lines.map(({ label, value }) => `${label}: ${value}`).join("\n");
  for (const part of ["of 2 ms · 3 repeated in smaller parts · 7 accepted without convergence", "17 bodies · 24 joints · 98 coordinates", "kinetic 12.3 kJ", "3 % (shortening of rod)", "Position error of joints: below 1 nm, below 10⁻⁶ °", "Velocity error of joints: 3 nm/s", "CPU time: 1.25 s · 6.4× real time"]) assert.ok(text.includes(part), `${part} in\n${text}`);
  const open = summaryLines({ ...summary, max_position_violation: 2.4e-5, max_angle_violation: 1e-4 }, { end: 8, step: 0.002, instants: 4001, bodies: 17, joints: 24 });
  assert.equal(open.find(({ label }) => label === "Position error of joints")?.value, "24 µm, 0.0057 °");
  assert.deepEqual(summaryLines(null, { end: NaN, step: 0.01, instants: 3, bodies: 1, joints: 0 }).map(({ label }) => label), ["Steps", "Recorded", "Mechanism"]);
});

test("warnings come first, and failure before them", () => {
  assert.deepEqual(warningsOf({ status: "ok", warnings: ["w"] }), ["w"]);
  assert.deepEqual(warningsOf({ status: "failed", message: "no convergence", warnings: ["w"] }), ["The run failed: no convergence", "w"]);
  assert.deepEqual(warningsOf({ status: "interrupted" }), ["The run ended as interrupted"]);
  assert.equal(quantity(0.0012, "m"), "1.2 mm");
});
