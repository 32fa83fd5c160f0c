// The report page in a browser, item by item: node page.mjs MIMBRE. Exits with 77 where there is no browser.
import assert from "node:assert/strict";
import { mkdtemp, readFile, rm, stat } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { drawn, launch, noBrowser, open, ready, Reports, resting } from "./browser.mjs";
import { textOf, until } from "./liveServer.mjs";

const skipped = 77;
const reason = await noBrowser();
if (reason !== "") {
  console.log(`SKIPPED: ${reason}`);
  process.exit(skipped);
}

const folder = await mkdtemp(join(tmpdir(), "mimbre-page-"));
const browserSoon = launch(); // while the models run
const reports = new Reports(process.argv[2], folder);
const rigModel = "web/tests/browser/rig.yaml";
const started = performance.now();
const craneModel = "web/tests/browser/crane.yaml";
const [rigRun, small, fine, coarse, constraintsRun, elementsRun] = await Promise.all([
  reports.run(rigModel, "rig"),
  reports.run("web/tests/browser/resonator.yaml", "resonator"),
  reports.run(craneModel, "fine"),
  reports.run(craneModel, "coarse", "--step", "0.04", "--until", "3.6"),
  reports.run("web/tests/browser/constraints.yaml", "constraints"),
  reports.run("web/tests/browser/force-elements.yaml", "elements"),
]);
const [rig, resonator, compared, constraints, elements] = await Promise.all([
  reports.report("rig", rigRun),
  reports.report("resonator", small),
  reports.report("compared", fine, coarse),
  reports.report("constraints", constraintsRun),
  reports.report("elements", elementsRun),
]);

const cases = [];
const test = (name, run) => cases.push([name, run]);

/** Where an object of the scene is, and whether it is seen; by the name of its group. */
const placeOf = (page, name) =>
  page.evaluate((wanted) => {
    const found = [];
    window.mimbreView.scene.traverse((object) => object.name === wanted && object.children.length > 0 && found.push(object));
    return found.map(({ position, visible, scale }) => ({ at: position.toArray(), visible, scale: scale.toArray() }));
  }, name);

/** Clicks in the picture where a joint is. */
async function clickOn(page, name) {
  await page.locator(".view canvas").scrollIntoViewIfNeeded();
  const [x, y] = await page.evaluate((wanted) => {
    const { elements, camera, canvas } = window.mimbreView;
    const { left, top } = canvas.getBoundingClientRect();
    const { x, y } = elements.find(({ element, isJoint }) => isJoint && element.name === wanted).group.position.clone().project(camera);
    return [left + ((1 + x) / 2) * canvas.clientWidth, top + ((1 - y) / 2) * canvas.clientHeight];
  }, name);
  await page.mouse.click(x, y);
}

const goTo = async (page, time) => {
  await page.evaluate((t) => window.mimbreView.clock.set(t), time);
  await drawn(page);
};

async function tab(page, name) {
  await page.getByRole("tab", { name }).click();
  return page.getByRole("tabpanel", { name });
}

async function downloaded(page, name) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name }).click()]);
  const path = join(folder, download.suggestedFilename());
  await download.saveAs(path);
  return path;
}

/** Moves the slider with this label to the end of its range. */
async function slideToEnd(page, label) {
  await page.getByLabel(label, { exact: true }).focus();
  await page.keyboard.press("End");
  await drawn(page);
}

const exaggeration = (page) => page.evaluate(() => window.mimbreView.exaggeration);

test("the first picture: playing about the largest deformation, see-through, drawn larger by a factor that is stated", async () => {
  // Every time at which the page plays, from its very first picture on.
  const watch = () => {
    window.playedTimes = [];
    const look = () => {
      requestAnimationFrame(look);
      if (window.mimbreView?.clock.playing) window.playedTimes.push(window.mimbreView.clock.time);
    };
    look();
  };
  const { page, complaints } = await open(browser, rig, {}, watch);
  const [instant, from] = await page.evaluate(() => {
    const { clock } = window.mimbreView;
    return [window.mimbreView.peak("displacement").time, clock.start];
  });
  assert.ok(instant > from);
  // From a moment before it over the end and round again.
  await page.waitForFunction(() => window.playedTimes.some((time, k) => time < window.playedTimes[k - 1]));
  const first = await page.evaluate(() => window.playedTimes[0]);
  assert.ok(first >= instant - 0.2501, `${first} s, the largest deformation is at ${instant} s`);
  const factor = await exaggeration(page);
  assert.ok(factor > 1, `${factor}`);
  assert.equal(await textOf(page, ".cell"), `Grid 0.2 m · Deformations drawn ${factor} times larger`);
  assert.ok(await page.getByLabel("See through solids").isChecked());
  assert.match(await textOf(page, ".colorbar small"), /^Largest: [\d.]+ mm in arm at [\d.]+ s$/);
  // It stops where a time is asked for, and without repeating at its end.
  await page.keyboard.press("ArrowRight");
  assert.equal(await page.evaluate(() => window.mimbreView.clock.playing), false);
  await page.getByLabel("Repeat").uncheck();
  await page.getByRole("button", { name: "Play" }).click();
  await page.waitForFunction(() => !window.mimbreView.clock.playing && window.mimbreView.clock.time === window.mimbreView.clock.end);
  assert.deepEqual(complaints, []);
  await page.close();
});

test("a page opened at a time rests there", async () => {
  const { page } = await open(browser, `${rig}#t=0.42`);
  await ready(page);
  await drawn(page);
  assert.deepEqual(await page.evaluate(() => [window.mimbreView.clock.time, window.mimbreView.clock.playing]), [0.42, false]);
  await page.close();
});

test("true scale when it is asked for; exaggerated, what hangs on a beam follows its tip", async ({ page }) => {
  await goTo(page, 0.3);
  await page.getByLabel("Exaggeration", { exact: true }).focus();
  await page.keyboard.press("Home");
  await drawn(page);
  assert.equal(await exaggeration(page), 1);
  assert.equal(await textOf(page, ".cell"), "Grid 0.2 m");
  const [before] = await placeOf(page, "bob");
  await slideToEnd(page, "Exaggeration");
  const [after] = await placeOf(page, "bob");
  const [pin] = await placeOf(page, "pin");
  assert.ok(Math.abs(after.at[2] - before.at[2]) > 0.05, `${before.at} ${after.at}`);
  // The bob's frame is where the joint is drawn: its origin lies 1 m along x and 0.6 m along z from the eye, in its axes.
  const gap = await page.evaluate(() => {
    const view = window.mimbreView;
    const amplitudes = view.report.bodies.map((_, k) => view.amplitudes(k));
    const { a, b } = view.report.elements.find(({ kind }) => kind === "revolute");
    const at = (frame) => view.placement.at(frame, view.placed, amplitudes, view.exaggeration).position;
    return at(a).distanceTo(at(b));
  });
  assert.ok(gap < 1e-9, `the pin is open by ${gap} m`);
  assert.ok(pin.visible);
  await page.getByLabel("Exaggeration", { exact: true }).focus();
  await page.keyboard.press("Home");
});

test("springs stretch between their ends; loads and reactions are arrows with a scale; the rig's plate moves", async ({ page }) => {
  await goTo(page, 0);
  const coil = () =>
    page.evaluate(() => {
      const group = window.mimbreView.elements.find(({ element }) => element.name === "strut").group;
      return { at: group.position.toArray(), stretch: group.children[0].scale.y, parts: group.children.length };
    });
  const start = await coil();
  assert.equal(start.parts, 3); // coil, cylinder, rod
  assert.ok(Math.abs(start.stretch - 1) < 1e-9);
  const plate = () => page.evaluate(() => window.mimbreView.plates[0].mesh.position.z + window.mimbreView.origin.z);
  const low = await plate();
  await goTo(page, 0.2);
  assert.ok(Math.abs((await plate()) - low - 0.03) < 1e-6);
  const length = await page.evaluate(() => window.mimbreView.report.signals("spring.strut.length").values);
  const stretched = await coil();
  assert.ok(Math.abs(stretched.stretch - length[100] / length[0]) < 1e-6, `${stretched.stretch}`);

  const arrows = () => page.evaluate(() => window.mimbreView.arrows.arrows.filter(({ group }) => group.visible).map(({ vector }) => vector.element.name));
  assert.deepEqual(await arrows(), ["push"]);
  await page.getByLabel("Forces", { exact: true }).selectOption("all");
  await drawn(page);
  assert.ok((await arrows()).includes("column") && (await arrows()).includes("wheel"));
  assert.match(await textOf(page, ".factor.wide output"), /^[\d.]+ k?N$/);
  await page.locator(".reactions summary").click();
  await page.locator(".reactions").getByLabel("column").uncheck();
  await drawn(page);
  assert.deepEqual((await arrows()).sort(), ["push", "weld", "wheel"]);
  await page.locator(".reactions").getByRole("button", { name: "None" }).click();
  await drawn(page);
  assert.deepEqual(await arrows(), ["push"]);
  assert.match(await textOf(page, ".reactions summary"), /^0 of \d reactions$/);
  await clickOn(page, "pin");
  await page.locator(".picked").getByLabel("arrow").check();
  await drawn(page);
  assert.deepEqual(await page.evaluate(() => [...window.mimbreView.arrows.chosen].map(({ name }) => name)), ["pin"]);
  const push = () => page.evaluate(() => { const { shaft, heads } = window.mimbreView.arrows.arrows.find(({ vector }) => vector.element.name === "push"); return shaft.scale.y + heads[0].scale.y; });
  const [long, newtons] = [await push(), Math.abs(60 * Math.sin(20 * 0.2))];
  const scale = await page.evaluate(() => window.mimbreView.arrows.perMetre.force);
  assert.ok(Math.abs(long - newtons / scale) < 1e-3 * long, `${long} m for ${newtons} N at ${scale} N per m`);
});

test("a joint's spring winds up with the joint's angle: its inner end goes with the second body", async ({ page }) => {
  const inner = async (time) => {
    await goTo(page, time);
    return page.evaluate(() => {
      const { report, elements, clock } = window.mimbreView;
      const { group } = elements.find(({ element }) => element.kind === "torsional spring damper about z");
      const { array } = group.children.find(({ geometry }) => geometry.type === "TubeGeometry").geometry.getAttribute("position");
      const angle = report.signals("bob.angle");
      const at = (k) => [array[3 * k], array[3 * k + 1]];
      const last = array.length / 3 - 4; // of the ring at the inner end
      return { turn: Math.atan2(...at(last).reverse()), first: at(0), angle: angle.values[Math.round(clock.time / 0.002)], parts: group.children.length };
    });
  };
  const [start, later] = [await inner(0), await inner(0.1)];
  assert.equal(later.parts, 2); // spiral and drum
  assert.deepEqual(later.first, start.first);
  const difference = later.turn - start.turn - (later.angle - start.angle);
  assert.ok(Math.abs(later.angle - start.angle) > 0.3);
  assert.ok(Math.abs(difference - 2 * Math.PI * Math.round(difference / (2 * Math.PI))) < 1e-4, `${difference} rad`);
});

test("bars are coloured by the stress of their deflection: at the root that of the joint's moment", async ({ page }) => {
  await goTo(page, 0.1);
  const { stress, point, moment } = await page.evaluate(() => {
    const view = window.mimbreView;
    const arm = view.report.bodies.findIndex(({ name }) => name === "arm");
    const values = view.bodies[arm].valuesAt(view.amplitudes(arm), "stress");
    const { time, values: moments } = view.report.signals("joint.weld.moment.y");
    const point = values.indexOf(Math.max(...values));
    return { stress: values[point], point: view.report.bodies[arm].points[3 * point], moment: moments[time.findIndex((t) => t >= view.clock.time - 1e-12)] };
  });
  const byHand = Math.abs(moment) / ((Math.PI / 32) * 0.02 ** 3);
  assert.ok(Math.abs(stress - byHand) < 0.05 * byHand, `${stress} Pa, by hand ${byHand} Pa`);
  assert.ok(Math.abs(point) < 1e-6, "the root");
  await page.getByLabel("Colour", { exact: true }).selectOption("stress");
  await drawn(page);
  assert.match(await textOf(page, ".colorbar span"), /stress, [kM]?Pa/);
  await page.getByLabel("Colour", { exact: true }).selectOption("none");
});

/** By the names of elements what is drawn of each: whether it is seen, and where its meshes are. */
const drawnElements = (page) =>
  page.evaluate(() => {
    const Vector = window.mimbreView.camera.position.constructor;
    window.mimbreView.scene.updateMatrixWorld(true);
    const all = {};
    for (const { element, group } of window.mimbreView.elements)
      (all[element.name] ??= []).push({ kind: element.kind, seen: group.visible, meshes: group.children.map((mesh) => new Vector().setFromMatrixPosition(mesh.matrixWorld).add(window.mimbreView.origin).toArray()) });
    return all;
  });
const apart = (a, b) => Math.hypot(...a.map((value, i) => value - b[i]));

test("constraints of every kind are drawn where they act", async () => {
  const { page, complaints } = await open(browser, constraints, resting);
  await goTo(page, 0.15);
  const all = await drawnElements(page);
  for (const name of ["mesh", "rail", "rod", "groove", "table", "wire", "upright", "square", "half_shaft", "thread"])
    assert.ok(all[name]?.[0].seen && all[name][0].meshes.length > 0, name);
  assert.equal(all.upright[0].meshes.length, 3); // a line and two axes
  assert.ok(apart(all.mesh[0].meshes[0], [-0.2, 0, 1.5]) < 1e-6); // from the first wheel
  // The bead is on the curve, whose mesh is in the axes of the ground's frame.
  const off = await page.evaluate(() => {
    const { group, first } = window.mimbreView.elements.find(({ element }) => element.name === "wire");
    const bead = group.children.find((mesh) => mesh !== first);
    const Vector = window.mimbreView.camera.position.constructor;
    const centre = new Vector().setFromMatrixPosition(bead.matrixWorld);
    const { array } = first.geometry.getAttribute("position");
    return Math.min(...Array.from({ length: array.length / 3 }, (_, k) => new Vector().fromArray(array, 3 * k).applyMatrix4(first.matrixWorld).distanceTo(centre)));
  });
  assert.ok(off < 0.03, `${off} m`);
  assert.deepEqual(complaints, []);
  await page.close();
});

test("force elements of every kind are drawn, drag as an arrow against the motion", async () => {
  const { page, complaints } = await open(browser, elements, resting);
  await goTo(page, 0.05);
  const all = await drawnElements(page);
  for (const name of ["strut", "rail", "flap", "bar", "mount", "hoist", "wheel"])
    assert.ok(all[name]?.some(({ seen, meshes }) => seen && meshes.length > 0), name);
  assert.deepEqual(all.flap.map(({ kind }) => kind).sort(), ["revolute", "stop about z"]);
  const arrow = await page.evaluate(() => {
    const { group } = window.mimbreView.arrows.arrows.find(({ vector }) => vector.element.kind === "drag");
    const Vector = window.mimbreView.camera.position.constructor;
    return { seen: group.visible, up: new Vector(0, 1, 0).applyQuaternion(group.quaternion).toArray() };
  });
  assert.ok(arrow.seen && arrow.up[2] > 0.999, `${arrow.up}`);
  assert.deepEqual(complaints, []);
  await page.close();
});

/** What is seen of a mechanism, in parts of its size and of the picture. */
const sight = (page) =>
  page.evaluate(() => {
    const view = window.mimbreView;
    const { camera, size, bodies, origin, ground, cell } = view;
    const Vector = camera.position.constructor;
    const places = bodies.flatMap(({ group, bounds }) =>
      [0, 1, 2, 3, 4, 5, 6, 7].map((k) => {
        const corner = new Vector(...["x", "y", "z"].map((axis, i) => bounds[k & (1 << i) ? "max" : "min"][axis]));
        return group.localToWorld(corner).project(camera).toArray();
      }),
    );
    const across = [0, 1].map((i) => Math.max(...places.map((place) => place[i])) - Math.min(...places.map((place) => place[i])));
    const bottom = Math.min(...bodies.map(({ group, bounds }) => group.position.z + bounds.min.z));
    const edges = bodies.map(({ group }) => group.children.flatMap((solid) => solid.children.map(({ geometry }) => geometry.getAttribute("position").count)));
    const arrows = view.arrows.arrows.filter(({ group }) => group.visible).map(({ shaft, heads }) => (shaft.scale.y + heads[0].scale.y) / size);
    // The middle of the first solid is not the sky.
    view.redraw();
    const gl = view.canvas.getContext("webgl2");
    const solid = bodies.flatMap(({ group }) => group.children).find(({ geometry, children }) => geometry?.type === "BoxGeometry" && children.length > 0);
    const [x, y] = new Vector().setFromMatrixPosition(solid.matrixWorld).project(camera).toArray();
    const pixel = (u, v) => {
      const read = new Uint8Array(4);
      gl.readPixels(Math.round(((1 + u) / 2) * view.canvas.width), Math.round(((1 + v) / 2) * view.canvas.height), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, read);
      return [...read];
    };
    return {
      inside: places.every((place) => place.every((value) => Math.abs(value) < 1)),
      filled: Math.max(...across) / 2,
      cells: size / cell,
      below: (bottom - ground) / size,
      edges: edges.flat(),
      arrows,
      contrast: Math.max(...pixel(x, y).map((value, i) => Math.abs(value - pixel(-0.98, 0.98)[i]))),
    };
  });

/** The drawn length of the sliding spring, less the channel of its joint. */
const slackOf = (page, channel) =>
  page.evaluate((name) => {
    const view = window.mimbreView;
    const { group, parts } = view.elements.find(({ element }) => element.kind.startsWith("sliding"));
    const { time, values } = view.report.signals(name);
    const { mesh, length } = parts.find(({ stretches }) => stretches);
    const at = time.findIndex((t) => t >= view.clock.time - 1e-12);
    return { slack: mesh.scale.y * length - values[at], value: values[at], children: group.children.length };
  }, channel);

for (const { name, of, moments, length, force, axis, time, channel } of [
  { name: "a millimetre", of: "phone", moments: [0, 1.13e-3], length: "Arrow of 1 mm", force: /^50 µN$/, axis: ["figcaption b", /^µm/], time: "1.13 ms", channel: "joint.rail.position" },
  { name: "a hundred metres", of: "compared", moments: [0, 3.2], length: "Arrow of 1 m", force: /^[\d.]+ kN$/, axis: ["figcaption .value", / m$/], time: "3.200 s", channel: "joint.rail.position" },
])
  test(`a thing of ${name} is seen whole, with its grid, edges, arrows, springs and units`, async (pages) => {
    const { page, complaints } = pages[of];
    await goTo(page, moments[0]);
    const before = await slackOf(page, channel);
    assert.equal(before.children, 4); // coil, cylinder, rod, seat
    await goTo(page, moments[1]);
    const after = await slackOf(page, channel);
    assert.ok(Math.abs(after.value - before.value) > 0 && Math.abs(after.slack - before.slack) < 1e-4 * Math.abs(after.value - before.value), JSON.stringify([before, after]));
    const { inside, filled, cells, below, edges, arrows, contrast } = await sight(page);
    assert.ok(inside && filled > 0.25, `${filled} of the picture`);
    assert.ok(cells > 2 && cells < 12, `${cells} cells`);
    assert.ok(below > -1e-6 && below < 0.1, `${below} above the ground`);
    assert.ok(edges.length > 1 && edges.every((count) => count === 24), `${edges}`); // of a box
    assert.ok(arrows.length > 0 && arrows.every((part) => part > 0.005 && part < 1), `${arrows}`);
    assert.ok(contrast > 30, `${contrast}`);
    assert.equal(await textOf(page, "output.time"), time);
    assert.equal(await textOf(page, ".factor.wide span"), length);
    assert.match(await textOf(page, ".factor.wide output"), force);
    assert.match(await textOf(page, axis[0]), axis[1]);
    assert.deepEqual(complaints, []);
  });

test("solids that hide the flexible arm are seen through until it is unticked, and wheels have marks that turn", async ({ page }) => {
  const drawnSolids = () => page.evaluate(() => window.mimbreView.bodies.flatMap(({ solids }) => solids.map(({ transparent, vertexColors }) => ({ transparent, vertexColors }))));
  assert.ok((await drawnSolids()).every(({ transparent }) => transparent));
  await page.getByLabel("See through solids").uncheck();
  const solids = await drawnSolids();
  assert.ok(solids.every(({ transparent }) => !transparent));
  assert.equal(solids.filter(({ vertexColors }) => vertexColors).length, 1); // the wheel
});

test("exports: CSV and pictures", async ({ page }) => {
  const csv = await readFile(await downloaded(page, "Save CSV"), "utf8");
  const lines = csv.trim().split("\r\n");
  assert.equal(lines.length, 502);
  assert.equal(lines[0], "t [s],tip.z [m],carriage.z [m],bob.angle [rad]");
  for (const name of ["Save plots", "Save picture"]) {
    const png = await readFile(await downloaded(page, name));
    assert.equal(png.subarray(1, 4).toString(), "PNG");
    assert.ok(png.length > 5000, `${name}: ${png.length} bytes`);
  }
});

/** How long a browser takes a film to be, in s, and its size in pixels. */
async function film(path) {
  const bytes = await readFile(path);
  assert.deepEqual([...bytes.subarray(0, 4)], [0x1a, 0x45, 0xdf, 0xa3]); // WebM
  const page = await browser.newPage();
  const seen = await page.evaluate(
    (content) =>
      new Promise((done, failed) => {
        const video = document.createElement("video");
        video.onerror = () => failed(new Error(video.error.message));
        video.onloadedmetadata = () => (video.currentTime = 0.2);
        video.onseeked = () => done({ duration: video.duration, at: video.currentTime, width: video.videoWidth, height: video.videoHeight });
        video.src = `data:video/webm;base64,${content}`;
      }),
    bytes.toString("base64"),
  );
  await page.close();
  return seen;
}

test("a film has the pictures of equal steps of simulated time, and lasts as long as the run at its speed", async ({ page }) => {
  await slideToEnd(page, "Speed"); // 4×
  const { duration, at, width, height } = await film(await downloaded(page, "Save film"));
  assert.ok(Math.abs(duration - (Math.ceil(30 / 4) + 1) / 30) < 2e-3, `${duration} s`);
  assert.ok(Math.abs(at - 0.2) < 1e-3);
  const canvas = await page.evaluate(() => [window.mimbreView.canvas.width, window.mimbreView.canvas.height]);
  assert.deepEqual([width, height], canvas.map((pixels) => 2 * Math.floor(pixels / 2)));
});

test("the summary is a dozen lines, details are folded, no card covers another", async ({ page }) => {
  const rows = await page.locator(".summary > table tr").count();
  assert.ok(rows >= 8 && rows <= 12, `${rows} rows`);
  assert.match(await textOf(page, ".summary > table"), /500 of 2 ms/);
  assert.equal(await page.locator(".summary details").getAttribute("open"), null);
  await page.locator(".model > summary").click();
  await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
  const [charts, model] = [await page.locator(".charts").boundingBox(), await page.locator(".model").boundingBox()];
  assert.ok(charts.x >= model.x + model.width, "the channels are beside the model");
});

test("axes: engineering units, whole labels, meanings as tooltips", async ({ page }) => {
  assert.match(await textOf(page, "figcaption b"), /^(m|mm)/);
  await page.getByLabel("Search channels").fill("pin force_joint");
  await page.getByText("joint.pin.force_joint.x").click();
  const title = await page.locator(".entry", { hasText: "joint.pin.force_joint.x" }).getAttribute("title");
  assert.match(title, /second body.*joint's own axes/);
});

test("x–y plots, spectra and a table of statistics", async ({ page }) => {
  let panel = await tab(page, "x–y");
  await panel.getByLabel("Channel on the horizontal axis").selectOption({ label: "carriage.z" });
  assert.ok((await panel.locator("canvas").count()) >= 2); // metres and degrees
  assert.ok((await panel.locator(".dot").count()) >= 2);
  // The rectangle that is drawn fills the plot: the dot goes where it belongs; a double click shows all.
  const plot = panel.locator(".u-over").first();
  const dotAt = async () => (await panel.locator(".dot").first().getAttribute("style")).match(/translate\(([-\d.]+)px, ([-\d.]+)px/).slice(1).map(Number);
  const { x, y, width, height } = await plot.boundingBox();
  const [left, top] = await dotAt();
  const corner = [Math.max(left - 0.2 * width, 0), Math.max(top - 0.2 * height, 0)];
  const size = [0.5 * width, 0.5 * height];
  await page.mouse.move(x + corner[0], y + corner[1]);
  await page.mouse.down();
  await page.mouse.move(x + corner[0] + size[0], y + corner[1] + size[1], { steps: 3 });
  await page.mouse.up();
  // The chart is built anew a moment later.
  await until(`the dot goes from ${left}, ${top} to its place in the rectangle`, async () => {
    const [zoomedLeft, zoomedTop] = await dotAt();
    return Math.abs(zoomedLeft - ((left - corner[0]) / size[0]) * width) < 3 && Math.abs(zoomedTop - ((top - corner[1]) / size[1]) * height) < 3;
  });
  await plot.dblclick({ position: { x: 20, y: 20 } });
  await until("the dot is back", async () => Math.abs((await dotAt())[0] - left) < 1);
  panel = await tab(page, "Spectrum");
  // The load's 20 rad/s is 3.18 Hz, the bob turns at about 9 rad/s: tip.z moves at a few hertz.
  assert.match(await panel.innerText(), /tip\.z.*peak [\d.]+ .*m at [\d.]+ Hz/s);
  await panel.getByLabel("Window").selectOption("flat top");
  await panel.getByLabel("Logarithmic").check();
  panel = await tab(page, "Table");
  const cells = await panel.locator("tbody tr").first().innerText();
  assert.match(cells, /tip\.z/);
  assert.match(cells, /global z of 'arm\.tip'/);
  assert.equal((await panel.locator("thead").innerText()).replace(/\s+/g, " ").trim(), "Channel Unit Minimum Maximum Mean RMS");
});

test("formulas are drawn, and what is wrong with them is said", async ({ page }) => {
  await tab(page, "Over time");
  const box = page.getByLabel("Formula over channels");
  await box.fill("tip.z - 2*nothing");
  await box.press("Enter");
  assert.match(await textOf(page, ".wrong"), /no channel 'nothing'/);
  await box.fill("tip.z - carriage.z");
  await box.press("Enter");
  assert.equal(await textOf(page, ".wrong"), "");
  assert.equal(await page.locator(".entry", { hasText: "tip.z - carriage.z" }).count(), 1);
});

test("without what films need the button is grey and says why", async ({ phone: { page } }) => {
  const button = page.getByRole("button", { name: "Save film" });
  await page.waitForFunction(() => document.querySelector(".exports small").textContent !== "");
  assert.ok(await button.isDisabled());
  assert.match(await button.getAttribute("title"), /neither WebCodecs nor MediaRecorder/);
});

test("without an encoder the film is recorded while it plays", async ({ compared: { page } }) => {
  const bytes = await readFile(await downloaded(page, "Save film"));
  assert.deepEqual([...bytes.subarray(0, 4)], [0x1a, 0x45, 0xdf, 0xa3]);
  assert.ok(bytes.length > 2000, `${bytes.length} bytes`);
});

test("the keyboard reaches all, and time is said", async ({ page }) => {
  await goTo(page, 0);
  await page.evaluate(() => document.activeElement.blur());
  await page.keyboard.press("ArrowRight");
  assert.match(await textOf(page, "output.time"), /0\.002 s/);
  await page.waitForFunction(() => document.querySelector("[aria-live=polite]").textContent === "Time 0.002 s");
  const before = await page.evaluate(() => window.mimbreView.camera.position.toArray());
  await page.locator(".view canvas").focus();
  await page.keyboard.press("ArrowRight");
  const after = await page.evaluate(() => window.mimbreView.camera.position.toArray());
  assert.notDeepEqual(after, before);
  assert.match(await textOf(page, "output.time"), /0\.002 s/); // in the picture the arrows turn it
  await page.getByRole("tab", { name: "Over time" }).click();
  await page.keyboard.press("ArrowRight");
  assert.equal(await page.getByRole("tab", { name: "x–y" }).getAttribute("aria-selected"), "true");
  const unnamed = await page.evaluate(() => [...document.querySelectorAll("button, input, select")].filter((one) => !one.closest("label") && !one.getAttribute("aria-label") && !one.textContent.trim()).length);
  assert.equal(unnamed, 0);
});

test("runs compared are drawn over each other, and can be hidden", async ({ compared: { page, complaints } }) => {
  const ghosts = () => page.evaluate(() => window.mimbreView.ghosts.map(({ views }) => views.map(({ group, solids }) => [group.visible, solids.every(({ transparent }) => transparent)])).flat());
  await drawn(page);
  assert.deepEqual(await ghosts(), [[true, true], [true, true], [true, true], [true, true]]);
  await page.locator(".run").nth(1).click();
  await drawn(page);
  assert.deepEqual((await ghosts()).map(([visible]) => visible), [false, false, false, false]);
  assert.deepEqual(complaints, []);
});

test("on a phone, in the dark: nothing is wider than the screen, the text has contrast", async ({ phone: { page, complaints } }) => {
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 390);
  const [text, back] = await page.evaluate(() => [getComputedStyle(document.body).color, getComputedStyle(document.body).backgroundColor]);
  const light = (color) => color.match(/\d+/g).map(Number).reduce((sum, part) => sum + part, 0);
  assert.ok(light(text) - light(back) > 400);
  // The search and the three buttons have lines of their own.
  const [search, card] = await Promise.all([".channels input[type=search]", ".channels"].map((part) => page.locator(part).first().boundingBox()));
  assert.ok(search.width > 0.95 * card.width, `${search.width} of ${card.width}`);
  const tops = await page.locator(".heading button").evaluateAll((buttons) => buttons.map((button) => button.getBoundingClientRect().top));
  assert.equal(new Set(tops).size, 1);
  assert.deepEqual(complaints, []);
});

test("on a phone a finger on the picture scrolls the page, and turns the picture after a tap", async ({ phone: { page } }) => {
  const touches = await page.context().newCDPSession(page);
  const seen = () => page.evaluate(() => ({ scrolled: scrollY, eye: window.mimbreView.camera.position.toArray() }));
  /** The page has come to rest, from a fling too. */
  const settled = async () => {
    for (let before = NaN, now = await seen(); now.scrolled !== before; now = await seen()) {
      before = now.scrolled;
      for (let k = 0; k < 3; ++k) await drawn(page);
    }
  };
  /** What a finger does that goes from the picture's middle by so many pixels. */
  const moved = async (right, down) => {
    await page.evaluate(() => scrollTo(0, 0));
    await settled();
    const { x, y, width, height } = await page.locator(".view canvas").boundingBox();
    const send = (type, part) => touches.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] : [{ x: x + width / 2 + part * right, y: y + height / 2 + part * down }] });
    const before = await seen();
    await send("touchStart", 0);
    for (let k = 1; k <= 4; ++k) await send("touchMove", k / 4);
    await send("touchEnd", 1);
    await settled();
    const after = await seen();
    return { scrolled: after.scrolled - before.scrolled, turned: Math.hypot(...after.eye.map((value, k) => value - before.eye[k])) > 1e-6 * Math.hypot(...before.eye) };
  };
  const scrolls = async () => {
    const { scrolled, turned } = await moved(0, -120);
    assert.ok(scrolled > 60 && !turned, `${scrolled} pixels, ${turned}`);
  };
  await scrolls();
  assert.deepEqual(await moved(60, 0), { scrolled: 0, turned: true });
  /** Taps, again where a tap only ended a fling, until the picture is taken or free. */
  const tapped = async (selector, picture) => {
    for (let k = 0; k < 5 && !(await page.locator(picture).count()); ++k) {
      await settled();
      await page.locator(selector).tap();
      await settled();
    }
    assert.equal(await page.locator(picture).count(), 1);
  };
  await tapped(".view canvas", ".view canvas.taken");
  assert.deepEqual(await moved(0, -60), { scrolled: 0, turned: true });
  await tapped("h1", ".view canvas:not(.taken)");
  await scrolls();
});

test("the page is one file that asks for nothing", async () => {
  const html = await readFile(reports.at("rig.html"), "utf8");
  assert.match(html, /default-src 'none'/);
  assert.ok((await stat(reports.at("rig.html"))).size < 2e6);
});

// One page for all that leave it as they found it, or only add to it: opening is what takes time.
const browser = await browserSoon;
const wanted = process.argv[3] ?? "";
const [shared, comparedPage, phone] = await Promise.all([
  open(browser, rig, resting),
  open(browser, compared, resting, () => delete window.VideoEncoder),
  open(browser, resonator, { ...resting, viewport: { width: 390, height: 844 }, colorScheme: "dark", hasTouch: true }, () => (delete window.VideoEncoder, delete window.MediaRecorder)),
]);
console.log(`the pages are open (${((performance.now() - started) / 1000).toFixed(1)} s)`);
const pages = { ...shared, compared: comparedPage, phone };
let failed = 0;
for (const [name, run] of cases.filter(([name]) => name.includes(wanted))) {
  const start = performance.now();
  try {
    await run(pages);
    assert.deepEqual(shared.complaints.splice(0), [], "the page complains");
    console.log(`ok   ${name} (${((performance.now() - start) / 1000).toFixed(1)} s)`);
  } catch (error) {
    ++failed;
    console.log(`FAIL ${name}\n${error.stack ?? error}`);
  }
}
await browser.close();
await rm(folder, { recursive: true });
process.exit(failed > 0 ? 1 : 0);
