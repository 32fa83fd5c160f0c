// The pages of modes and of Bode plots in a browser, item by item: node linear.mjs MIMBRE. Exits with 77 where there is no browser.
import assert from "node:assert/strict";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { drawn, launch, noBrowser, open, ready, Reports, resting } from "./browser.mjs";

const reason = await noBrowser();
if (reason !== "") {
  console.log(`SKIPPED: ${reason}`);
  process.exit(77);
}

const folder = await mkdtemp(join(tmpdir(), "mimbre-linear-"));
const browserSoon = launch();
const reports = new Reports(process.argv[2], folder);
const made = async (name, ...words) => {
  await reports.mimbre(...words, "-o", reports.at(`${name}.html`));
  return `file://${reports.at(`${name}.html`)}`;
};
const [rotor, rig, driven, bode] = await Promise.all([
  made("rotor", "modes", "examples/rotor/two-discs.yaml", "--at", "steady", "--most", "8"),
  made("rig", "modes", "web/tests/browser/rig.yaml", "--most", "12"),
  made("none", "modes", "examples/delta-robot/model.yaml"),
  made("bode", "linearise", "web/tests/browser/driven.yaml", "--frequencies", "0.01:100:120"),
]);
const browser = await browserSoon;

const cases = [];
const test = (name, run) => cases.push([name, run]);
const textOf = (page, selector) => page.locator(selector).first().innerText();
const placeOf = (page, body) => page.evaluate((k) => window.mimbreView.bodies[k].group.position.toArray(), body);
const phase = async (page, degrees) => {
  await page.getByLabel("Phase of the oscillation").fill(String(degrees));
  await drawn(page);
};

test("a list of modes with what they consist of; the chosen one moves", async () => {
  const { page, complaints } = await open(browser, `${rotor}#mode=3&phase=0`, resting);
  await ready(page);
  assert.match(await textOf(page, "h1"), /^Rotor of two discs: modes$/);
  assert.equal(await page.locator("table.mechanism tbody tr").count(), 8);
  assert.match(await textOf(page, "tr.chosen td.text"), /forward whirl/);
  assert.match(await textOf(page, "output.picked"), /^Mode 3, /);
  await page.keyboard.press("ArrowUp");
  assert.match(await textOf(page, "output.picked"), /^Mode 2, /);
  await phase(page, 0);
  const before = await placeOf(page, 1);
  await phase(page, 180);
  const after = await placeOf(page, 1);
  assert.ok(Math.hypot(...before.map((value, k) => value - after[k])) > 0.01);
  await page.getByRole("button", { name: "Play" }).click();
  await page.waitForFunction((place) => window.mimbreView.bodies[1].group.position.toArray().some((value, k) => Math.abs(value - place[k]) > 0.01), after);
  await page.keyboard.press("Space");
  assert.equal(await page.getByRole("button", { name: "Pause" }).count(), 0);
  assert.deepEqual(complaints, []);
  await page.close();
});

test("forward whirl goes round with the rotation, seen from the ground", async () => {
  for (const [mode, sense] of [[3, 1], [2, -1]]) {
    const { page } = await open(browser, `${rotor}#mode=${mode}&phase=0`, resting);
    await ready(page);
    await page.getByLabel("Seen from").selectOption("ground");
    // The sum of the areas that the disc's centre goes round, about x.
    const round = await page.evaluate(async () => {
      const group = window.mimbreView.bodies[1].group;
      const places = [];
      document.querySelector("button.play").click();
      const start = performance.now();
      while (performance.now() - start < 2500) {
        await new Promise((done) => requestAnimationFrame(done));
        places.push([group.position.y, group.position.z]);
      }
      const middle = [0, 1].map((axis) => places.reduce((sum, place) => sum + place[axis], 0) / places.length);
      return places.slice(1).reduce((sum, [y, z], k) => sum + (places[k][0] - middle[0]) * (z - middle[1]) - (places[k][1] - middle[1]) * (y - middle[0]), 0);
    });
    assert.ok(round * sense > 0, `mode ${mode}: ${round}`);
    await page.close();
  }
});

test("the amplitude is that of the slider, joints stay closed", async () => {
  const { page, complaints } = await open(browser, `${rig}#phase=0`, resting);
  await ready(page);
  const gap = () =>
    page.evaluate(() => {
      const { placement, placed, report, clock } = window.mimbreView;
      const amplitudes = report.bodies.map(({ firstMode, modes }) => report.animation.modes.slice(firstMode, firstMode + modes));
      const held = report.elements.filter(({ kind }) => kind === "revolute" || kind === "spherical");
      return Math.max(...held.map(({ a, b }) => placement.at(a, placed, amplitudes, 1).position.distanceTo(placement.at(b, placed, amplitudes, 1).position))) + 0 * clock.time;
    });
  const small = await placeOf(page, 0);
  await page.getByLabel("Amplitude", { exact: true }).focus();
  await page.keyboard.press("End");
  await drawn(page);
  assert.match(await textOf(page, ".factor output"), /^50 % of the size$/);
  assert.ok((await gap()) < 1e-3 * (await page.evaluate(() => window.mimbreView.size)));
  assert.ok(small.every(Number.isFinite));
  assert.deepEqual(complaints, []);
  await page.close();
});

test("a mechanism without modes has a page", async () => {
  const { page, complaints } = await open(browser, driven, resting);
  assert.match(await textOf(page, ".view .hint"), /nothing to animate/);
  assert.deepEqual(complaints, []);
  await page.close();
});

test("Bode plots: input, outputs, scales, values under the cursor, CSV", async () => {
  const { page, complaints } = await open(browser, bode, resting);
  assert.equal(await page.locator("figure").count(), 2);
  // Nothing responds to the first one, the drag at rest.
  assert.equal(await page.getByLabel("Input", { exact: true }).inputValue(), "1");
  for (const scale of ["linear", "logarithmic", "decibels"]) {
    await page.getByLabel("Magnitude", { exact: true }).selectOption(scale);
    assert.equal(await page.locator("figure").count(), 2);
  }
  assert.match(await textOf(page, "figure .value"), / dB\) at [\d.·⁰-⁹⁻]+ Hz$/);
  const { x, y, width, height } = await page.locator("figure .u-over").first().boundingBox();
  await page.mouse.move(x + width / 2, y + height / 2);
  await drawn(page);
  assert.match(await textOf(page, ".plots .hint"), /^At [\d.]+ Hz$/);
  await page.getByLabel("Input", { exact: true }).selectOption({ index: 2 });
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Save CSV" }).click()]);
  const path = join(folder, download.suggestedFilename());
  await download.saveAs(path);
  const lines = (await readFile(path, "utf8")).trim().split("\r\n");
  assert.equal(lines.length, 121);
  assert.match(lines[0], /^frequency \[Hz\],/);
  await page.getByRole("button", { name: "Clear" }).click();
  assert.equal(await page.locator("figure").count(), 0);
  assert.deepEqual(complaints, []);
  await page.close();
});

const wanted = process.argv[3] ?? "";
let failed = 0;
for (const [name, run] of cases.filter(([name]) => name.includes(wanted))) {
  try {
    await run();
    console.log(`ok   ${name}`);
  } catch (error) {
    ++failed;
    console.log(`FAIL ${name}\n${error.stack ?? error}`);
  }
}
await browser.close();
await rm(folder, { recursive: true });
process.exit(failed > 0 ? 1 : 0);
