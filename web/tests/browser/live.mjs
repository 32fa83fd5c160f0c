// The live page in a browser, item by item: node live.mjs MIMBRE [MODEL] [WORDS OF AN ITEM]. Exits with 77 where there
// is no browser. MODEL instead of driven.yaml needs inputs called steering, throttle and brake.
import assert from "node:assert/strict";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { drawn, launch, noBrowser, open, ready, Reports } from "./browser.mjs";
import { alone, driving, handsOff, inControl, lastingPort, pause, rate, resume, serveModel, state, take, textOf, until } from "./liveServer.mjs";
import { mockLive } from "./mockLive.mjs";

const skipped = 77;
const reason = await noBrowser();
if (reason !== "") {
  console.log(`SKIPPED: ${reason}`);
  process.exit(skipped);
}

const [, , program, model = "web/tests/browser/driven.yaml", wanted = ""] = process.argv;
const folder = await mkdtemp(join(tmpdir(), "mimbre-live-"));

const serve = (port) => serveModel(program, model, "--port", String(port), "--record", join(folder, "drive.h5"));

const cases = [];
const test = (name, run) => cases.push([name, run]);

const number = (page, name) => page.getByLabel(`${name}, as a number`);
const value = async (page, name) => Number(await number(page, name).inputValue());
const time = async (page) => Number.parseFloat(await textOf(page, ".time"));
/** What the server has, whatever the page shows already or still. */
const ask = async (page, path) => (await fetch(new URL(path, page.url()))).json();
const status = (page) => ask(page, "/status");
const tracks = async (page) => (await ask(page, "/inputs")).tracks;
const atServer = async (page, name) => (await tracks(page))[name].values.at(-1);
/** What the page has told the server of an input, value by value. */
const told = (sent, name) => sent.map(({ values }) => values?.[name]).filter((one) => one !== undefined);

/** Keeps every text that an element shows from now on: one may follow another at once, or be gone before it is looked for. */
const collect = (page, selector) =>
  page.evaluate((wanted) => {
    const region = document.querySelector(wanted);
    const texts = ((window.collectedTexts ??= {})[wanted] = []);
    const keep = () => region.hidden || texts.push(region.textContent);
    keep();
    new MutationObserver(keep).observe(region, { attributes: true, childList: true, characterData: true, subtree: true });
  }, selector);
const collected = (page, selector) => page.evaluate((wanted) => window.collectedTexts[wanted], selector);
const announcements = "header [role=status]";

/** The server's status once it says that it is paused: its steps do not change any more. */
const pausedStatus = (page) =>
  until("the server is paused", async () => {
    const now = await status(page);
    return now.state === "paused" && now;
  });

/** Everything as at the start, running; nobody touches anything. */
async function afresh(page) {
  await inControl(page);
  await handsOff(page);
  const stop = page.getByRole("button", { name: "Stop playback" });
  if (await stop.isVisible()) await stop.click();
  await pause(page);
  await page.keyboard.press("r");
  await until("a reset", async () => (await time(page)) === 0 && (await status(page)).time === 0);
  await resume(page);
}

test("who looks on sees everything, and is told why nothing can be driven", async ({ page }) => {
  await state(page, "Running");
  assert.match(await textOf(page, ".control-words"), /Nobody is in control/);
  assert.ok(await number(page, "throttle").isDisabled());
  assert.ok(await page.getByRole("button", { name: "Reset" }).isDisabled());
  const before = await time(page);
  await until("the time goes on", async () => (await time(page)) > before + 0.3);
  // Of the last second: at times that of a machine that has other work.
  await until("its pace", async () => /(^|\s)(0\.[89]\d?|1(\.[01]\d?)?)× real time/.test(await textOf(page, ".states")));
  await until("values in the legends", async () => /\d/.test(await textOf(page, ".strips .entry .value")));
  assert.ok((await page.locator(".strips canvas").count()) > 0);
});

test("the deadlines are told: the last step, the spread, the histogram", async ({ page }) => {
  await until("the table", async () => /^[\d.]+ [µm]?s$/.test(await textOf(page, ".spread td:last-child")));
  const cells = await page.locator(".spread tbody td").allInnerTexts();
  assert.equal(cells.length, 12);
  const inSeconds = (text) => Number.parseFloat(text) * { s: 1, ms: 1e-3, µs: 1e-6, ns: 1e-9 }[text.split(" ")[1]];
  const [median, , , worst] = cells.map(inSeconds);
  assert.ok(median > 1e-7 && median <= worst, cells.join());
  assert.ok((await page.locator(".histogram rect.computing").count()) > 0);
  assert.match(await textOf(page, ".overruns"), /late/);
  const meter = page.getByRole("meter");
  await until("the meter", async () => Number(await meter.getAttribute("aria-valuenow")) >= 0);
});

test("keys drive: pedals and steering rise with time, come back, and no more is sent than needed", async ({ page, sent }) => {
  await afresh(page);
  sent.length = 0;
  const start = performance.now();
  await driving(page, true, "w");
  await driving(page, true, "ArrowLeft");
  await until("full throttle", async () => (await value(page, "throttle")) === 1 && (await value(page, "steering")) === 1);
  // What is shown goes out with the next picture of the screen at the latest.
  await until("it is sent", () => told(sent, "throttle").at(-1) === 1 && told(sent, "steering").at(-1) === 1);
  const messages = sent.filter((order) => order.do === "inputs").length;
  const passed = (performance.now() - start) / 1000;
  for (const name of ["throttle", "steering"]) {
    const values = told(sent, name);
    assert.ok(values.length > 1 && values.every((one, k) => k === 0 || one > values[k - 1]), `${name} rises: ${values}`);
  }
  assert.ok(messages <= 1 + passed / 0.015, `${messages} messages in ${passed} s`);
  const before = sent.length;
  await page.waitForTimeout(300);
  await drawn(page);
  assert.deepEqual(sent.slice(before), [], "nothing is sent while nothing changes");
  await driving(page, false, "w");
  await driving(page, false, "ArrowLeft");
  await until("back", async () => (await value(page, "throttle")) === 0 && (await value(page, "steering")) === 0);
  await driving(page, true, "Space");
  await until("the brake", async () => (await value(page, "brake")) === 1);
  await driving(page, false, "Space");
  await until("the brake is off", async () => (await value(page, "brake")) === 0);
  // When the window is left, nobody holds the keys.
  await driving(page, true, "w");
  await until("throttle", async () => (await value(page, "throttle")) > 0.2);
  await page.evaluate(() => dispatchEvent(new Event("blur")));
  await until("let go", async () => (await value(page, "throttle")) === 0 && (await atServer(page, "throttle")) === 0);
});

test("what is typed drives nothing; P pauses, steps are single, R begins anew", async ({ page, sent }) => {
  await afresh(page);
  sent.length = 0;
  await page.getByLabel("Name of the snapshot").fill("");
  await page.getByLabel("Name of the snapshot").type("wasp r");
  assert.equal(await page.getByLabel("Name of the snapshot").inputValue(), "wasp r");
  await drawn(page);
  assert.deepEqual(sent, []);
  assert.equal(await textOf(page, ".pill"), "Running");
  await page.getByLabel("Name of the snapshot").fill("");
  await page.evaluate(() => document.activeElement.blur());
  await pause(page);
  const rested = await pausedStatus(page);
  await page.waitForTimeout(300);
  assert.equal((await status(page)).steps, rested.steps);
  await until("the time of the pause", async () => Math.abs((await time(page)) - rested.time) < 0.0051);
  await page.getByRole("button", { name: "Step", exact: true }).click();
  await until("a step", async () => (await status(page)).steps > rested.steps);
  await page.waitForTimeout(100);
  assert.equal((await status(page)).steps, rested.steps + 1);
  await resume(page);
  await afresh(page);
});

test("sliders, numbers within their bounds, and parameters in a fold", async ({ page }) => {
  await afresh(page);
  const slider = page.getByRole("slider", { name: "throttle" });
  await slider.focus();
  await page.keyboard.press("End");
  await until("the slider", async () => (await value(page, "throttle")) === 1 && (await atServer(page, "throttle")) === 1);
  await number(page, "throttle").fill("-7");
  await page.keyboard.press("Enter");
  await until("the bound", async () => (await value(page, "throttle")) === 0 && (await atServer(page, "throttle")) === 0);
  const [tunable] = await page.locator(".driving details.all input[type=number]").all();
  const name = (await tunable.getAttribute("aria-label")).replace(", as a number", "");
  assert.ok(!(await tunable.isVisible()));
  await page.locator(".driving details.all > summary").click();
  await tunable.fill("55.5");
  await page.keyboard.press("Enter");
  await until("the server has it", async () => (await atServer(page, name)) === 55.5);
  await page.waitForTimeout(500); // then the page shows what the server has, not what was typed
  await until("so has the page", async () => (await tunable.inputValue()) === "55.5");
  await page.locator(".driving details.all > summary").click();
});

test("a key and a gamepad's part can be given to any input", async ({ page, sent }) => {
  await afresh(page);
  const row = page.locator(".input").nth(3);
  const name = (await row.locator("input[type=number]").getAttribute("aria-label")).replace(", as a number", "");
  await row.locator("summary").click();
  const more = row.getByRole("button", { name: "Key to increase" });
  await more.click();
  await page.keyboard.press("u");
  assert.equal(await row.locator("summary").innerText(), "U");
  await page.evaluate(() => document.activeElement.blur());
  await driving(page, true, "u");
  await until("it rises", async () => Number(await row.locator("input[type=number]").inputValue()) > 0);
  await driving(page, false, "u");
  await drawn(page);
  await until("the server has it", async () => (await atServer(page, name)) === told(sent, name).at(-1));
  const left = await atServer(page, name);
  await page.waitForTimeout(400);
  assert.ok((await atServer(page, name)) >= left, "it stays");
  await until("it is shown", async () => Number(await row.locator("input[type=number]").inputValue()) >= Number(left.toPrecision(5)));
  await row.locator("summary").click();
});

test("a gamepad: the stick's left is left, triggers are pedals, and it rests when nobody touches it", async ({ page }) => {
  await afresh(page);
  const pad = (axes, buttons) =>
    page.evaluate(
      ([axes, buttons]) => {
        window.pad = { connected: true, axes, buttons: Array.from({ length: 17 }, (_, k) => ({ value: buttons[k] ?? 0 })) };
        navigator.getGamepads = () => [null, window.pad];
      },
      [axes, buttons],
    );
  await pad([0.03, 0, 0, 0], {});
  await drawn(page); // it is seen at rest first
  await until("the steering is back from what was driven before", async () => (await value(page, "steering")) === 0);
  await page.waitForTimeout(200);
  assert.equal(await value(page, "steering"), 0);
  await pad([1, 0, 0, 0], { 7: 0.5 });
  await until("right and half throttle", async () => (await value(page, "steering")) === -1 && (await value(page, "throttle")) === 0.5);
  await pad([0, 0, 0, 0], { 6: 1 });
  await until("braking", async () => Math.abs(await value(page, "steering")) < 1e-9 && (await value(page, "throttle")) === 0 && (await value(page, "brake")) === 1);
  const row = page.locator(".input").first();
  await row.locator("summary").click();
  await row.getByLabel(/^Gamepad control/).selectOption("axis 2");
  await pad([0, 0, -0.6, 0], {});
  await until("the other stick", async () => (await value(page, "steering")) < -0.4);
  await row.getByLabel(/^Gamepad control/).selectOption("axis 0 reversed");
  await row.locator("summary").click();
  await afresh(page);
});

test("snapshots are kept, listed and gone back to", async ({ page }) => {
  await afresh(page);
  await pause(page);
  const kept = (await pausedStatus(page)).time;
  await page.getByLabel("Name of the snapshot").fill("at the <i>start</i>");
  await page.keyboard.press("Enter");
  const list = page.getByLabel("Snapshot to restore");
  await until("it is listed", async () => (await list.inputValue()) === "at the <i>start</i>");
  await page.evaluate(() => document.activeElement.blur());
  await resume(page);
  await until("later", async () => (await time(page)) > kept + 0.5);
  await pause(page);
  await page.getByRole("button", { name: "Restore" }).click();
  await until("back", async () => (await status(page)).time === kept && Math.abs((await time(page)) - kept) < 0.0051);
  await resume(page);
});

test("what was driven is saved, and gives the same when it is driven again", async ({ page, heard }) => {
  await afresh(page);
  await driving(page, true, "w");
  await until("full throttle", async () => (await value(page, "throttle")) === 1 && (await atServer(page, "throttle")) === 1);
  await driving(page, false, "w");
  await until("let go", async () => (await value(page, "throttle")) === 0 && (await atServer(page, "throttle")) === 0);
  const download = async (name) => {
    const [file] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name, exact: true }).click()]);
    await file.saveAs(join(folder, file.suggestedFilename()));
    return join(folder, file.suggestedFilename());
  };
  const saved = JSON.parse(await readFile(await download("Save JSON"), "utf8"));
  const { throttle } = saved.tracks;
  assert.ok(Math.max(...throttle.values) === 1 && throttle.values.at(-1) === 0);
  await page.getByLabel("Inputs in the CSV file").selectOption("throttle");
  const csv = await readFile(await download("Save CSV"), "utf8");
  assert.match(csv, /^t \[s\],throttle\r\n0,0\r\n/);
  await page.getByLabel("Inputs in the CSV file").selectOption("");

  // Played and over: it may not last as long as it takes to look.
  heard.length = 0;
  const played = () => heard.filter(({ say }) => say === "played").map(({ on }) => on);
  await page.getByRole("button", { name: "Play back" }).click();
  await until("playback, and its end", () => played().length >= 2);
  assert.deepEqual(played(), [true, false]);
  await until("its end is shown", async () => !(await page.getByRole("button", { name: "Stop playback" }).isVisible()));
  const again = (await tracks(page)).throttle;
  assert.deepEqual(again, throttle, JSON.stringify([again, throttle]));

  // One that lasts until it is ended.
  const long = join(folder, "long.json");
  await writeFile(long, JSON.stringify({ ...saved, tracks: { throttle: { times: [0, 0.1, 1e4], values: [0, 1, 0] } } }));
  await page.locator(".recorded-inputs input[type=file]").setInputFiles(long);
  await until("the file is played", async () => page.getByRole("button", { name: "Stop playback" }).isVisible());
  await until("it is told", async () => /Playing back/.test(await textOf(page, ".recorded-inputs [role=status]")));
  await until("full throttle", async () => (await value(page, "throttle")) === 1);
  await page.getByRole("button", { name: "Stop playback" }).click();
  await until("it is ended", async () => !(await page.getByRole("button", { name: "Stop playback" }).isVisible()));
  const other = join(folder, "other.csv");
  await writeFile(other, "t,gear\n0,1\n");
  await page.locator(".recorded-inputs input[type=file]").setInputFiles(other);
  await until("what is wrong", async () => /no input “gear”/.test(await textOf(page, ".recorded-inputs .wrong")));
});

test("results are recorded where the server runs", async ({ page }) => {
  await afresh(page);
  const [begin, end] = [page.getByRole("button", { name: "Record", exact: true }), page.getByRole("button", { name: "Stop recording" })];
  await until("recording from the start", async () => end.isVisible());
  await end.click();
  await until("its end", async () => begin.isVisible());
  await begin.click();
  await until("recording again", async () => end.isVisible());
});

test("channels are chosen from the list, taken away, and held still", async ({ page }) => {
  const search = page.getByLabel("Search channels");
  await page.getByText(/^Select from \d+ channels$/).click();
  const before = await page.locator(".strips .entry").count();
  await search.fill("energy.kinetic");
  await page.locator(".channel-groups input[type=checkbox]").first().check();
  await until("one more", async () => (await page.locator(".strips .entry").count()) === before + 1);
  await until("its value", async () => /J$/.test(await page.locator(".strips .entry", { hasText: "energy.kinetic" }).locator(".value").innerText()));
  await page.locator(".strips .entry", { hasText: "energy.kinetic" }).getByRole("button").click();
  assert.equal(await page.locator(".strips .entry").count(), before);
  await search.fill("");
  await page.getByText(/^Select from \d+ channels$/).click();
  await page.getByRole("button", { name: "Freeze" }).click();
  const still = await textOf(page, ".strips .entry .value");
  await page.waitForTimeout(400);
  assert.equal(await textOf(page, ".strips .entry .value"), still);
  await page.getByRole("button", { name: "Freeze" }).click();
});

test("two viewers: the second looks on, asks, and gets control when the first hands it over", async ({ page, browser, server }) => {
  await afresh(page);
  await collect(page, announcements);
  const { page: second, complaints } = await open(browser, server.url);
  await collect(second, announcements);
  await state(second, "Running");
  await until("another has control", async () => /Another viewer/.test(await textOf(second, ".control-words")));
  await until("two viewers", async () => /2 viewers/.test(await textOf(page, ".states")));
  await driving(page, true, "w");
  await until("the other's throttle is seen", async () => (await value(second, "throttle")) > 0.5);
  await driving(page, false, "w");
  assert.ok(await number(second, "throttle").isDisabled());
  await second.keyboard.press("p"); // without effect
  await take(second).click();
  await until("asked", async () => /have requested/.test(await textOf(second, ".control-words")));
  assert.equal(await textOf(page, ".pill"), "Running");
  const asking = page.locator(".asking");
  await until("the first is told", async () => /^Viewer \d+ requests control/.test(await textOf(page, ".asking")));
  await until("it is announced", async () => (await collected(page, announcements)).some((words) => /^Viewer \d+ requests control$/.test(words)));
  await asking.getByRole("button", { name: "Not now" }).click();
  assert.ok(!(await asking.isVisible()));
  for (const words of ["Another viewer", "You have requested"]) {
    await take(second).click(); // not any more, and again
    await until(words, async () => (await textOf(second, ".control-words")).includes(words));
  }
  await asking.getByRole("button", { name: "Hand over" }).click();
  await until("handed over", async () => (await textOf(second, ".take")) === "Release control");
  await until("the first drives no more", async () => page.getByRole("button", { name: "Reset" }).isDisabled());
  await until("that is announced", async () => (await collected(second, announcements)).some((words) => /You are in control/.test(words)));
  await second.close();
  await until("free again", async () => /Nobody/.test(await textOf(page, ".control-words")));
  assert.deepEqual(complaints.filter((text) => !/WebGL/.test(text)), []);
});

test("the keyboard alone: everything is reached in order, seen, and left again", async ({ page }) => {
  await afresh(page);
  await page.locator("h1").click(); // from there on
  const seen = [];
  for (let k = 0; k < 80; ++k) {
    await page.keyboard.press("Tab");
    const now = await page.evaluate(() => {
      const one = document.activeElement;
      if (one === document.body) return null;
      const { outlineStyle } = getComputedStyle(one);
      return { name: one.getAttribute("aria-label") ?? one.textContent ?? "", marked: outlineStyle !== "none", tag: one.tagName };
    });
    if (now === null) break;
    seen.push(now);
  }
  const names = seen.map(({ name }) => name);
  assert.ok(seen.length > 20 && seen.length < 80, `${seen.length}: ${names.join(" | ")}`);
  for (const name of ["Pause", "Reset", "Release control", "Snapshot", "throttle, as a number", "Freeze", "Save JSON"]) assert.ok(names.includes(name), name);
  assert.ok(names.indexOf("Pause") < names.indexOf("Release control") && names.indexOf("Release control") < names.indexOf("Freeze"));
  assert.deepEqual(seen.filter(({ marked }) => !marked), []);
});

test("names are text, nothing is loaded from elsewhere, and every control has a name", async ({ page, requests, server }) => {
  assert.equal(await page.locator("h1 b, option i, .channel-groups b").count(), 0);
  assert.ok(requests.length > 1 && requests.every((url) => url.startsWith("data:") || url.startsWith("blob:") || new URL(url).host === new URL(server.url).host), requests.join());
  assert.match(await (await fetch(server.url)).text(), /default-src 'none'[^"]*connect-src 'self'/);
  const nameless = await page.evaluate(() =>
    [...document.querySelectorAll("button, input, select, summary")].filter((one) => !(one.getAttribute("aria-label") || one.textContent.trim() || one.labels?.length)).map((one) => one.outerHTML),
  );
  assert.deepEqual(nameless, []);
});

test("a phone: nothing is cut, fingers steer and give way", async ({ browser, server, page }) => {
  await inControl(page);
  await take(page).click();
  await until("free", async () => (await textOf(page, ".take")) === "Take control");
  const { page: phone, complaints } = await open(browser, server.url, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, colorScheme: "dark" });
  await state(phone, "Running");
  assert.ok(!(await phone.locator(".pads").isVisible()));
  await take(phone).tap();
  await until("pads", async () => phone.locator(".pads").isVisible());
  const { scroll, wide } = await phone.evaluate(() => ({ scroll: document.documentElement.scrollWidth, wide: document.documentElement.clientWidth }));
  assert.ok(scroll <= wide, `${scroll} of ${wide} pixels`);
  const session = await phone.context().newCDPSession(phone);
  const at = async (selector, x, y) => {
    const { left, top, width, height } = await phone.locator(selector).evaluate((one) => one.getBoundingClientRect().toJSON());
    return { x: left + x * width, y: top + y * height };
  };
  const [left, gas] = [await at(".pad.steering", 0.05, 0.5), await at(".pad.throttle", 0.5, 0.05)];
  await session.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: [{ ...left, id: 1 }, { ...gas, id: 2 }] });
  await until("two fingers drive", async () => (await value(phone, "steering")) === 1 && (await value(phone, "throttle")) === 1);
  await session.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  await until("let go", async () => (await value(phone, "steering")) === 0 && (await value(phone, "throttle")) === 0);
  await phone.screenshot({ path: join(folder, "phone.png") });
  await phone.close();
  assert.deepEqual(complaints.filter((text) => !/WebGL/.test(text)), []);
});

test("the server ends and comes back: the page says so, and goes on by itself", async ({ page, context }) => {
  await afresh(page);
  const { port } = context.server;
  await context.server.stop();
  await state(page, "Server ended");
  assert.match(await textOf(page, ".banner"), /has ended or cannot be reached/);
  assert.ok(await number(page, "throttle").isDisabled());
  await page.evaluate(() => (window.sameDocument = true));
  context.server = await serve(port);
  await state(page, "Running");
  assert.ok(await page.evaluate(() => window.sameDocument), "it was not loaded anew");
  await inControl(page);
  await driving(page, true, "w");
  await until("driving again", async () => (await value(page, "throttle")) === 1);
  await driving(page, false, "w");
});

/** Apart: the page of the mock, which can be brought to what the server only comes to by accident. */
const mocked = [];
const mockTest = (name, run) => mocked.push([name, run]);

mockTest("a failure is said with its reason, and a reset is offered", async ({ page, mock }) => {
  await inControl(page);
  Object.assign(mock.state, { failed: true, message: "the step at 1.2 s did not converge <b>" });
  await state(page, "Failed");
  await until("the reason", async () => /did not converge <b>/.test(await textOf(page, ".banner")));
  await page.locator(".banner").getByRole("button", { name: "Reset" }).click();
  await state(page, "Running");
  await until("the banner goes", async () => !(await page.locator(".banner").first().isVisible()));
});

mockTest("overruns are told with their causes", async ({ page }) => {
  await until("causes", async () => (await page.locator(".causes li").count()) === 2);
  assert.match(await textOf(page, ".overruns"), /^3 of [\d\u202f]+ steps were late/);
  assert.deepEqual(await page.locator(".causes li").allInnerTexts(), ["1 × late wake-up", "2 × preempted by other work"]);
});

mockTest("an order that the server refuses is shown", async ({ page, mock }) => {
  const banner = "header .banner:nth-of-type(2)"; // hidden again after some seconds
  await collect(page, banner);
  mock.say({ say: "error", message: "too many requests at once" });
  await until("it is shown", async () => (await collected(page, banner)).includes("Server: too many requests at once"));
});

mockTest("the vehicle is drawn where the server has it, and the eye stays behind it", async ({ page, mock }) => {
  await ready(page);
  await inControl(page);
  await driving(page, true, "a");
  await until("half a turn", () => mock.state.yaw > 2.5);
  await driving(page, false, "a");
  await until("straight on", async () => (await value(page, "steering")) === 0);
  await pause(page);
  const seen = () =>
    page.evaluate(() => {
      const { bodies, origin, camera, controls } = window.mimbreView;
      const chassis = bodies.findIndex(({ body }) => body.name === "chassis");
      return { place: bodies[chassis].group.position.clone().add(origin).toArray(), eye: camera.position.clone().sub(controls.target).toArray() };
    });
  await until("it is where the server has it", async () => {
    const { place } = await seen();
    return Math.hypot(place[0] - mock.state.x, place[1] - mock.state.y) < 1e-5;
  });
  const ahead = [Math.cos(mock.state.yaw), Math.sin(mock.state.yaw)];
  await until("the eye is behind it", async () => {
    const { eye } = await seen();
    return (eye[0] * ahead[0] + eye[1] * ahead[1]) / Math.hypot(eye[0], eye[1]) < -0.7;
  });
  await resume(page);
});

mockTest("forces are asked for when they are drawn, and stand on their scale", async ({ page, mock }) => {
  await page.locator(".viewing > summary").click();
  await page.getByLabel("Forces", { exact: true }).selectOption("all");
  const asked = () => mock.heard.filter((order) => order.do === "channels").at(-1)?.indices ?? [];
  await until("channels of tyres", async () => asked().some((k) => /^tyre\..*\.vertical$/.test(mock.channels[k].name)));
  await until("arrows", async () => page.evaluate(() => window.mimbreView.arrows.arrows.some(({ group }) => group.visible)));
  await until("the scale", async () => /k?N/.test(await textOf(page, ".factor.wide output")));
  await page.getByLabel("Forces", { exact: true }).selectOption("none");
  await until("no more", async () => !asked().some((k) => /\.vertical$/.test(mock.channels[k].name)));
  await page.getByLabel("Colour", { exact: true }).selectOption("displacement");
  await until("the colours' scale", async () => /so far/.test(await textOf(page, ".colorbar")));
  await page.locator(".viewing > summary").click();
});

mockTest("pictures a second, drawn by software: no moment that the view is brought to is left out", async ({ page }) => {
  await ready(page);
  await state(page, "Running");
  const { drawn, leftOut, words } = await rate(page);
  console.log(`     ${words}`);
  assert.ok(drawn > 0, "none is drawn");
  assert.equal(leftOut, 0, "some are left out");
});

let failed = 0;
async function runAll(all, given, complaints) {
  for (const [name, run] of all.filter(([name]) => name.includes(wanted))) {
    const start = performance.now();
    try {
      await run(given);
      assert.deepEqual(complaints.splice(0).filter((text) => !/WebGL|ERR_CONNECTION_REFUSED|WebSocket connection/.test(text)), [], "the page complains");
      console.log(`ok   ${name} (${((performance.now() - start) / 1000).toFixed(1)} s)`);
    } catch (error) {
      ++failed;
      console.log(`FAIL ${name}\n${error.stack ?? error}`);
      await tidy(given);
    }
  }
}

/** The next case is not to suffer from what one that failed has left. */
async function tidy({ page, browser, mock }) {
  await alone(page, browser);
  await handsOff(page);
  if (mock) Object.assign(mock.state, { paused: false, failed: false });
}

const context = { server: await serve(await lastingPort()) };
const browser = await launch(false);
{
  const requests = [];
  const [sent, heard] = [[], []]; // orders, and what the server says
  const listen = (page) => {
    page.on("request", (request) => requests.push(request.url()));
    page.on("websocket", (socket) => {
      socket.on("framesent", ({ payload }) => sent.push(JSON.parse(String(payload))));
      socket.on("framereceived", ({ payload }) => typeof payload === "string" && heard.push(JSON.parse(payload)));
    });
  };
  const { page, complaints } = await open(browser, context.server.url, { viewport: { width: 1280, height: 900 } }, undefined, listen);
  await runAll(cases, { page, browser, context, server: context.server, requests, sent, heard }, complaints);
  await browser.close();
  await context.server.stop();
}

if (mocked.some(([name]) => name.includes(wanted))) {
  const reports = new Reports(program, folder);
  const mock = await mockLive((await reports.report("iltis", await reports.run("examples/iltis/vehicle.yaml", "iltis"))).replace("file://", ""));
  const drawing = await launch();
  const { page, complaints } = await open(drawing, mock.url, { viewport: { width: 480, height: 620 } });
  await runAll(mocked, { page, browser: drawing, mock }, complaints);
  await drawing.close();
  await mock.stop();
}

await rm(folder, { recursive: true });
process.exit(failed > 0 ? 1 : 0);
