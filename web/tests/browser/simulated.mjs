// A page of `mimbre page` in a browser, opened as a file: node simulated.mjs MIMBRE [WORDS OF AN ITEM]. Exits with 77 where
// there is no browser, or the program has no solver for pages.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { mkdtemp, readFile, rm, stat } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { drawn, launch, noBrowser, open, root } from "./browser.mjs";
import { driving, handsOff, pause, resume, serveModel, state, textOf, until } from "./liveServer.mjs";

const skipped = 77;
const noSolver = "no solver for pages; make page builds it (Debian: apt-get install emscripten)";
const reason = (await noBrowser()) || (existsSync(join(root, "build/wasm/mimbre.wasm")) ? "" : noSolver);
if (reason !== "") {
  console.log(`SKIPPED: ${reason}`);
  process.exit(skipped);
}

const [, , program, wanted = ""] = process.argv;
const model = "examples/iltis/drive.yaml";
const folder = await mkdtemp(join(tmpdir(), "mimbre-simulated-"));
const file = join(folder, "drive.html");
const began = performance.now();
try {
  execFileSync(resolve(program), ["page", model, "-o", file, "--quiet", "--solver", "build/wasm/mimbre.wasm"], { cwd: root, stdio: ["ignore", "inherit", "inherit"] });
} catch (error) {
  console.log(`FAIL mimbre page\n${error}`);
  process.exit(1);
}
console.log(`the page was made in ${((performance.now() - began) / 1000).toFixed(1)} s`);

const cases = [];
const test = (name, run) => cases.push([name, run]);

/** The newest picture: time, s; clock, s; positions. */
const newest = (page) => page.evaluate(() => ({ ...window.mimbrePage.newest(), positions: [...window.mimbrePage.newest().positions] }));
const time = async (page) => (await newest(page)).time;

async function afresh(page) {
  await handsOff(page);
  await pause(page);
  await page.keyboard.press("r");
  await until("the start", async () => (await time(page)) === 0);
  await resume(page);
}

test("it is one file of less than 8 MB that names nothing outside", async () => {
  const { size } = await stat(file);
  console.log(`     ${(size / 1e6).toFixed(2)} MB`);
  assert.ok(size < 8e6);
  const text = await readFile(file, "utf8");
  assert.doesNotMatch(text, /<(script|img|iframe|link|source)[^>]*(src|href)\s*=\s*["']?https?:/i);
  assert.match(text, /default-src 'none'/);
});

test("keys drive it for 20 s, and it says how its time runs", async ({ page }) => {
  await afresh(page);
  const start = await newest(page);
  const hold = async (name, seconds) => {
    await driving(page, true, name);
    await page.waitForTimeout(1000 * seconds);
    await driving(page, false, name);
  };
  await driving(page, true, "w");
  await page.waitForTimeout(4000);
  await hold("a", 0.5);
  await page.waitForTimeout(3000);
  await hold("d", 0.5);
  await page.waitForTimeout(6000);
  await driving(page, false, "w");
  await hold("s", 4);
  await page.waitForTimeout(2000);
  const end = await newest(page);
  const pace = (end.time - start.time) / (end.clock - start.clock);
  console.log(`     ${pace.toFixed(3)} × real time over ${(end.clock - start.clock).toFixed(1)} s; ${await textOf(page, ".states")}`);
  const shown = await until("its pace", async () => /([\d.]+)× real time/.exec(await textOf(page, ".states")));
  assert.ok(Number(shown[1]) > 0);
  assert.ok(end.clock - start.clock > 20);
  assert.ok(end.positions[0] - start.positions[0] > 10 * Math.min(pace, 1), `driven ${end.positions[0] - start.positions[0]} m`);
  assert.ok(end.positions.every(Number.isFinite));
  await state(page, "Running");
});

/** Plays inputs from the start for `seconds` of the simulation at least, and then on to `steps`. In the browser. */
async function played({ socket, tracks, seconds, steps }) {
  const far = { steps: 0, time: NaN, paused: false };
  let send = (order) => window.mimbrePage.order(order);
  let look = () => Object.assign(far, window.mimbrePage.newest());
  if (socket) {
    const connection = new WebSocket(new URL("/ws", location.href.replace("http", "ws")), socket);
    connection.binaryType = "arraybuffer";
    connection.onmessage = ({ data }) => {
      if (typeof data === "string") return;
      const view = new DataView(data);
      const bodies = Number(window.bodies);
      Object.assign(far, { paused: (view.getUint8(1) & 1) === 1, control: (view.getUint8(1) & 32) !== 0, time: view.getFloat64(8, true), positions: Array.from({ length: 3 * bodies }, (_, k) => view.getFloat64(40 + 8 * k, true)) });
    };
    await new Promise((done) => (connection.onopen = done));
    send = (order) => connection.send(JSON.stringify(order));
    look = () => {};
    send({ do: "control", take: true });
  }
  const wait = async (condition) => {
    for (;;) {
      look();
      if (condition()) return;
      await new Promise((done) => setTimeout(done, 5));
    }
  };
  await wait(() => far.time >= 0 && (!socket || far.control));
  if (tracks) {
    send({ do: "pause" });
    await wait(() => far.paused);
    send({ do: "reset" });
    await wait(() => far.time === 0);
    send({ do: "play", tracks });
    send({ do: "resume" });
    await wait(() => far.time >= seconds);
    send({ do: "pause" });
    await wait(() => far.paused);
  }
  // Step by step from here on.
  while (far.time < seconds - 1e-9) {
    const { time } = far;
    send({ do: "step" });
    await wait(() => far.time > time);
  }
  return { time: far.time, positions: [...far.positions] };
}

test("it moves as mimbre live does by the same inputs over 5 s", async ({ page, browser }) => {
  const { tracks } = JSON.parse(await page.evaluate(() => window.mimbrePage.driven()));
  assert.ok(Object.values(tracks).some(({ times }) => times.length > 10), "nothing was recorded");
  await pause(page);
  const socket = /protocol = "([^"]+)"/.exec(await readFile(join(root, "web/src/liveProtocol.ts"), "utf8"))[1];
  const server = await serveModel(program, model, "--port", "0");
  try {
    const far = await browser.newPage();
    await far.goto(new URL("/scene", server.url).href);
    await far.evaluate(() => (window.bodies = JSON.parse(document.body.innerText).bodies.length));
    let there = await far.evaluate(played, { socket, tracks, seconds: 5 });
    let here = await page.evaluate(played, { tracks, seconds: 5 });
    if (here.time < there.time - 1e-9) here = await page.evaluate(played, { seconds: there.time });
    if (there.time < here.time - 1e-9) there = await far.evaluate(played, { socket, seconds: here.time });
    assert.ok(Math.abs(here.time - there.time) < 1e-9, `${here.time} and ${there.time}`);
    const apart = Math.max(...here.positions.map((x, k) => Math.abs(x - there.positions[k])));
    console.log(`     ${apart.toExponential(2)} m apart at ${here.time.toFixed(3)} s, ${here.positions[0].toFixed(2)} m ahead`);
    assert.ok(apart < 1e-6, `${apart} m`);
    await far.close();
  } finally {
    await server.stop();
  }
  await resume(page);
});

test("it pauses, makes one step, keeps and restores a snapshot", async ({ page }) => {
  await afresh(page);
  await pause(page);
  const before = await newest(page);
  await page.getByRole("button", { name: "Step", exact: true }).click();
  await until("a step", async () => (await time(page)) > before.time);
  const kept = await newest(page);
  assert.ok(Math.abs(kept.time - before.time - 0.001) < 1e-9);
  await page.getByLabel("Name of the snapshot").fill("here");
  await page.getByRole("button", { name: "Snapshot" }).click();
  await until("the snapshot", async () => (await page.locator(".snapshots option").allInnerTexts()).includes("here"));
  await page.evaluate(() => document.activeElement.blur());
  await resume(page);
  await until("it goes on", async () => (await time(page)) > kept.time + 0.1);
  await pause(page);
  await page.getByRole("button", { name: "Restore" }).click();
  await until("it is there again", async () => (await time(page)) === kept.time);
  assert.deepEqual((await newest(page)).positions, kept.positions);
  await resume(page);
});

test("charts, sliders and a gamepad", async ({ page }) => {
  await afresh(page);
  assert.ok((await page.locator(".strips canvas").count()) > 0);
  await until("values in the legends", async () => /\d/.test(await textOf(page, ".strips .entry .value")));
  await page.getByLabel("throttle, as a number").fill("0.5");
  await page.keyboard.press("Enter");
  await until("the throttle", async () => (await newest(page)).inputs[1] === 0.5);
  await handsOff(page);
  const pad = (axes) =>
    page.evaluate((axes) => (navigator.getGamepads = () => [{ connected: true, axes, buttons: Array.from({ length: 17 }, () => ({ value: 0 })) }]), axes);
  await pad([0, 0, 0, 0]);
  await drawn(page); // it is seen at rest first
  await pad([-1, 0, 0, 0]);
  await until("it steers", async () => Math.abs((await newest(page)).inputs[0]) > 0.5);
  await handsOff(page);
});

test("a browser without WebAssembly is told so", async ({ browser }) => {
  const page = await browser.newPage();
  await page.addInitScript(() => delete window.WebAssembly);
  await page.goto(`file://${file}`);
  await until("the reason", async () => /WebAssembly/.test(await page.locator("[role=alert]").first().innerText()));
  await page.close();
});

let failed = 0;
const browser = await launch(false);
const asked = [];
const { page, complaints } = await open(browser, `file://${file}`, { viewport: { width: 1280, height: 900 } }, undefined, (page) => {
  page.on("request", (request) => asked.push(request.url()));
  page.on("websocket", (socket) => asked.push(socket.url()));
});
await page.context().setOffline(true);
await until("a picture", () => page.evaluate(() => window.mimbrePage?.newest() !== undefined));
for (const [name, run] of cases.filter(([name]) => name.includes(wanted))) {
  const start = performance.now();
  try {
    await run({ page, browser });
    assert.deepEqual(complaints.splice(0).filter((text) => !/WebGL/.test(text)), [], "the page complains");
    assert.deepEqual(asked.filter((url) => !/^(file:|blob:|data:)/.test(url)), [], "the page asks the network");
    console.log(`ok   ${name} (${((performance.now() - start) / 1000).toFixed(1)} s)`);
  } catch (error) {
    ++failed;
    console.log(`FAIL ${name}\n${error.stack ?? error}`);
    await handsOff(page);
  }
}
await browser.close();
await rm(folder, { recursive: true });
process.exit(failed > 0 ? 1 : 0);
