// The pictures of docs/: node pictures.mjs MIMBRE FOLDER [NAME]. Each is a report page at a telling moment; with NAME only those
// whose names hold it.
import { mkdtemp, rm, stat } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { drawn, launch, noBrowser, open, ready, Reports, resting } from "./browser.mjs";

const [program, target] = process.argv.slice(2);
const most = 240_000; // bytes of a picture
const reason = await noBrowser();
if (reason !== "") {
  console.error(`pictures: ${reason}`);
  process.exit(1);
}

const folder = await mkdtemp(join(tmpdir(), "mimbre-pictures-"));
const reports = new Reports(program, folder);

const spinUp = "examples/spin-up-beam/beam-3d.yaml";
const arm = "examples/solid-arm/arm.h5";

/**
 * Which model with which settings, what its page is asked for, and what is set on it before the picture is taken.
 * `others`: further runs that are compared with it, by their labels. `body`: the page of a body's modes. `scene`: only the
 * animation, not the page around it.
 */
const pictures = [
  { name: "report", model: "examples/iltis/vehicle.yaml" },
  { name: "suspension", model: "examples/iltis/suspension.yaml", time: 2.2, forces: "all", exaggerate: 20, through: true, tab: "Spectrum" },
  { name: "four-bar", model: "examples/tutorial/four-bar.yaml", time: 1.69, forces: "all", tab: "Table" },
  { name: "slider-crank", model: "examples/slider-crank/slider-crank.yaml", label: "flexible", others: [["rigid", "--set", "rod=rigid"]], time: 0.181 },
  { name: "bricard", model: "examples/bricard/mechanism.yaml", time: 0.8, forces: "all", tab: "x–y" },
  { name: "pendulum", model: "examples/pendulum/flexible.yaml", time: 0.9, forces: "all", exaggerate: 100 },
  { name: "stairs", model: "examples/contact/stairs.yaml", time: 0.42 },
  { name: "double-four-bar", model: "examples/double-four-bar/mechanism.yaml", options: ["--set", "flexible_bars=5"], time: 0.75, forces: "all", exaggerate: 20 },
  { name: "solid-arm", model: "examples/solid-arm/suspension.yaml", time: 2.3, asked: "color=stress", through: true, nearer: "front_left.arm" },
  { name: "solid-arm-modes", body: arm, asked: "family=1&mode=1&t=1" },
  { name: "crank-train", model: "examples/crank-train/model.yaml", scene: true, time: 0.0212, forces: "all", exaggerate: 20 },
  { name: "washing-machine", model: "examples/washing-machine/model.yaml", scene: true, time: 2.2, through: true },
  { name: "stewart-platform", model: "examples/stewart-platform/model.yaml", scene: true, time: 1.3, forces: "all" },
  { name: "delta-robot", model: "examples/delta-robot/model.yaml", scene: true, time: 0.2, forces: "all" },
  { name: "double-wishbone", model: "examples/double-wishbone/model.yaml", scene: true, time: 0.6, forces: "all", through: true },
  { name: "rotor", model: "examples/rotor/model.yaml", scene: true, time: 5.6, exaggerate: 20, through: true },
  { name: "wind-turbine", model: "examples/wind-turbine/model.yaml", scene: true, time: 12 },
  { name: "bar-stress", model: "examples/robot/model.yaml", scene: true, time: 1.2, asked: "color=stress", through: true },
  { name: "robot", model: "examples/robot/model.yaml", scene: true, time: 1, forces: "all", exaggerate: 20 },
  { name: "solar-array", model: "examples/solar-array/model.yaml", scene: true, time: 8 },
  { name: "ball-cascade", model: "examples/ball-cascade/model.yaml", scene: true, time: 0.012 },
  { name: "force-elements", model: "web/tests/browser/force-elements.yaml", scene: true, time: 0.1, forces: "loads", through: true, turned: [-0.4, 0, 1.15] },
  { name: "constraints", model: "web/tests/browser/constraints.yaml", scene: true, time: 0.15, through: true, turned: [-0.4, 0, 1.15] },
  { name: "spin-up", model: "examples/spin-up-beam/beam-2d.yaml", time: 8, tab: "x–y" },
  {
    name: "spin-up-comparison",
    model: spinUp,
    options: ["--set", "method=nonlinear_beam"],
    label: "nonlinear beams",
    others: [
      ["foreshortening", "--set", "method=foreshortening"],
      ["5 substructures", "--set", "method=substructuring", "--set", "substructures=5"],
      ["nonlinear stiffness", "--set", "method=nonlinear_stiffness_1", "--set", "axial_modes=1", "--set", "axial_end=free"],
      ["linear", "--set", "method=linear"],
    ],
    time: 6,
    size: { width: 1600, height: 1720 },
  },
];

/** Runs of a picture, one after the other: they say what they cost. */
async function runs({ name, model, options = [], label, others = [] }) {
  const made = [];
  for (const [one, ...settings] of [[label ?? name, ...options], ...others]) made.push({ label: one, ...(await reports.timed(model, `${name}-${made.length}`, ...settings)) });
  return made;
}

async function address(picture) {
  const { name, body, asked, label } = picture;
  const of = body ? [body] : await runs(picture);
  const page = body ? await reports.report(name, body) : label ? await reports.comparison(name, of) : await reports.report(name, of[0].results);
  return page + (asked ? `#${asked}` : "");
}

async function set(page, { time, exaggerate, forces, through, tab, nearer, turned }) {
  if (time !== undefined) await page.evaluate((t) => window.mimbreView.clock.set(t), time);
  // Through the slider, so that what it shows is what is drawn; its ends are 1 and 500.
  if (exaggerate)
    await page.getByLabel("Exaggeration", { exact: true }).evaluate((slider, factor) => {
      slider.value = String(Math.log(factor) / Math.log(500));
      slider.dispatchEvent(new Event("input"));
    }, exaggerate);
  if (forces) await page.getByLabel("Forces", { exact: true }).selectOption(forces);
  if (through) await page.getByLabel("See through solids").check();
  if (tab) await page.getByRole("tab", { name: tab }).click();
  if (turned) await page.evaluate((by) => window.mimbreView.turn(...by), turned);
  if (!nearer) return;
  await page.evaluate((name) => {
    const view = window.mimbreView;
    const { group } = view.bodies[view.report.bodies.findIndex((body) => body.name === name)];
    view.controls.target.copy(group.position);
    view.turn(0.25, 0.1, 0.42);
  }, nearer);
}

const width = 1180;
const wanted = process.argv[4] ?? "";
const browser = await launch();
for (const picture of pictures.filter(({ name }) => name.includes(wanted))) {
  const { name, size, scene } = picture;
  const { page, complaints } = await open(browser, await address(picture), { ...resting, viewport: size ?? { width, height: 800 } });
  await set(page, picture);
  // As high as the card of the animation.
  const card = await page.locator(".player").boundingBox();
  if (!size) await page.setViewportSize({ width, height: Math.round(card.y + card.height + 14) });
  await ready(page);
  await drawn(page);
  const path = join(target, `${name}.png`);
  await page.screenshot({ path, clip: scene ? await page.locator(".player canvas").first().boundingBox() : undefined });
  const bytes = (await stat(path)).size;
  console.log(`${path}: ${(bytes / 1000).toFixed(0)} kB`);
  const allowed = size ? 2 * most : most;
  if (bytes > allowed) throw new Error(`${path} has ${bytes} bytes, more than ${allowed}`);
  if (complaints.length > 0) throw new Error(complaints.join("\n"));
  await page.close();
}
await browser.close();
await rm(folder, { recursive: true });
