// The vehicle of `make live` is driven in a browser, and how it moves is read from the pictures that the page is sent:
// node drive.mjs MIMBRE [WORDS OF AN ITEM]. Exits with 77 where there is no browser.
import assert from "node:assert/strict";
import { drawn, launch, noBrowser, open } from "./browser.mjs";
import { alone, driving, handsOff, inControl, pause, resume, serveModel, state, take, textOf, until } from "./liveServer.mjs";

const skipped = 77;
const reason = await noBrowser();
if (reason !== "") {
  console.log(`SKIPPED: ${reason}`);
  process.exit(skipped);
}

const [, , program, wanted = ""] = process.argv;
const model = "examples/iltis/drive.yaml";
const patience = 120; // s, much: the machine may have other work

/** The chassis as the server tells a page of it (docs/live-protocol.md): the first body of every picture. */
class Motion {
  time = NaN;
  highest = -Infinity; // m
  speed = NaN; // ahead, m/s
  moved = NaN; // the last time at which it did
  turned = 0; // rad, to the left, since begin()
  looks = new Set(); // what is done with every picture

  constructor(bodies) {
    this.bodies = bodies;
  }

  listen(page) {
    page.on("websocket", (socket) => socket.on("framereceived", ({ payload }) => typeof payload !== "string" && this.see(payload)));
  }

  begin() {
    [this.turned, this.highest] = [0, -Infinity];
  }

  see(picture) {
    const time = picture.readDoubleLE(8);
    this.steps = Number(picture.readBigUInt64LE(24));
    const [x, y, z] = [40, 48, 56].map((at) => picture.readDoubleLE(at));
    const [qw, qx, qy, qz] = [0, 4, 8, 12].map((at) => picture.readFloatLE(40 + 24 * this.bodies + at));
    const yaw = Math.atan2(2 * (qx * qy + qw * qz), 1 - 2 * (qy * qy + qz * qz));
    this.roll = Math.atan2(2 * (qw * qx + qy * qz), 1 - 2 * (qx * qx + qy * qy));
    const passed = time - this.time;
    if (passed < 0) this.speed = NaN; // put back
    if (passed > 0) {
      const turn = yaw - this.yaw;
      this.turned += Math.atan2(Math.sin(turn), Math.cos(turn));
      this.speed = ((x - this.x) * Math.cos(yaw) + (y - this.y) * Math.sin(yaw)) / passed;
    }
    if (!(Math.abs(this.speed) < 0.02)) this.moved = time;
    this.highest = Math.max(this.highest, z);
    Object.assign(this, { time, x, y, z, yaw });
    for (const look of [...this.looks]) look();
  }

  /** For half a second: braking, it rocks to and fro before. */
  get stands() {
    return this.time > this.moved + 0.5;
  }

  /** Until a picture shows it. Every one is looked at: on a busy machine what lasts a moment is over at the next look. */
  until(what, condition) {
    if (condition()) return undefined;
    return new Promise((done, failed) => {
      const end = (settle, value) => {
        this.looks.delete(look);
        clearTimeout(timer);
        settle(value);
      };
      const look = () => condition() && end(done);
      const timer = setTimeout(() => end(failed, new assert.AssertionError({ message: `not within ${patience} s: ${what}` })), 1000 * patience);
      this.looks.add(look);
    });
  }
}

async function looking(browser, url, options = {}) {
  const { bodies } = await (await fetch(new URL("/scene", url))).json();
  assert.equal(bodies[0].name, "chassis");
  const motion = new Motion(bodies.length);
  const { page, complaints } = await open(browser, url, options, undefined, (page) => motion.listen(page));
  await motion.until("a picture", () => motion.time >= 0);
  return { page, motion, complaints };
}

/** At the start again, paused, nothing touched. */
async function toStart(page, motion) {
  await inControl(page);
  await handsOff(page);
  await pause(page);
  await page.keyboard.press("r");
  await motion.until("the start", () => motion.time === 0 && Math.abs(motion.y) < 0.1 && Math.abs(motion.roll) < 0.1);
  motion.begin();
}

/** An input as the page has it; it is sent with that picture of the screen, or the next. */
const value = async (page, name) => Number(await page.getByLabel(`${name}, as a number`).inputValue());

/** From the start at its first speed, with these keys held down from the first step on, however late they would come. */
async function holding(page, motion, keys) {
  await toStart(page, motion);
  for (const [key, name, full] of keys) {
    await driving(page, true, key);
    await until(`all of ${name}`, async () => (await value(page, name)) === full);
  }
  await resume(page);
}

const throttle = ["w", "throttle", 1];
const left = ["a", "steering", 1];

const cases = [];
const test = (name, options, run) => cases.push({ name, options, run });
const quick = ["--speed", "2"];

test("the ground has the hill, each stair, the bank and the ice", quick, async ({ url }) => {
  const { bodies, roads } = await (await fetch(new URL("/scene", url))).json();
  const bytes = Buffer.from(bodies.find(({ name }) => name === "ground").points.data, "base64");
  const points = Array.from({ length: bytes.length / 12 }, (_, k) => [0, 4, 8].map((at) => bytes.readFloatLE(12 * k + at)));
  const heights = (low, high, side) => points.filter(([x, y]) => x >= low && x <= high && Math.sign(y + 8.5) === side).map(([, , z]) => z);
  const near = (value, wanted, what) => assert.ok(Math.abs(value - wanted) < 0.02, `${what}: ${value}`);
  near(Math.max(...heights(40, 60, 1)), 1.5, "the hill");
  for (const [edge, above] of [[117, 0.5], [120, 0.4], [123, 0.3], [126, 0.2], [129, 0.1]]) {
    near(Math.max(...heights(edge - 0.4, edge + 0.4, 1)), above, `above ${edge} m`);
    near(Math.min(...heights(edge - 0.4, edge + 0.4, 1)), above - 0.1, `below ${edge} m`);
  }
  assert.ok(Math.max(...heights(0, 200, -1)) > 6, "the bank");
  assert.deepEqual(roads.map(({ patches }) => patches), [[{ x: [80, 95], y: [-8, 0], friction: 0.15 }]], "the ice");
});

test("W takes speed, over the hill and down again", quick, async ({ page, motion }) => {
  await holding(page, motion, [throttle]);
  await motion.until("on the hill", () => motion.x > 47);
  await motion.until("behind the hill", () => motion.x > 82 && motion.z < 0.65 && motion.speed > 8);
  assert.ok(motion.highest > 1.9, `${motion.highest} m`);
  await driving(page, false, "w");
  await until("no throttle", async () => (await value(page, "throttle")) === 0);
  const rolling = motion.speed;
  await motion.until("it rolls on, ever more slowly", () => motion.speed < rolling - 0.2);
});

test("A turns to the left, D to the right", quick, async ({ page, motion }) => {
  await holding(page, motion, [throttle, left]);
  await motion.until("to the left", () => motion.turned > 0.6 && motion.y > 0.5);
  await driving(page, false, "a");
  await driving(page, true, "d");
  const turned = motion.turned;
  await motion.until("back, and to the right", () => motion.turned < Math.min(turned - 1, -0.4));
});

test("S and the space bar brake to a standstill, and no further", quick, async ({ page, motion }) => {
  for (const key of ["s", "Space"]) {
    await holding(page, motion, [[key, "brake", 1]]);
    await motion.until("it rolls", () => motion.speed > 3);
    await motion.until("it stands", () => motion.stands);
    const [time, place] = [motion.time, motion.x];
    await motion.until("for some time", () => motion.time > time + 2);
    assert.ok(Math.abs(motion.x - place) < 0.02 && place > 0 && place < 12, `${place} m, then ${motion.x} m`);
    await driving(page, false, key);
  }
  await driving(page, true, "w");
  await motion.until("on it goes", () => motion.speed > 1);
});

test("what is held down while it is put back drives on", quick, async ({ page, motion }) => {
  await holding(page, motion, [throttle]);
  await motion.until("faster", () => motion.speed > 8);
  await pause(page);
  await page.keyboard.press("r");
  await motion.until("the start", () => motion.time === 0);
  await resume(page);
  await motion.until("at its first speed", () => motion.speed < 6);
  await motion.until("faster again", () => motion.speed > 8);
});

test("a gamepad drives: triggers are pedals, the stick's left is left", quick, async ({ page, motion }) => {
  await toStart(page, motion);
  const pad = (stick, brake, throttle) =>
    page.evaluate(
      ([stick, brake, throttle]) => {
        const buttons = Array.from({ length: 17 }, (_, k) => ({ value: { 6: brake, 7: throttle }[k] ?? 0 }));
        navigator.getGamepads = () => [{ connected: true, axes: [stick, 0, 0, 0], buttons }];
      },
      [stick, brake, throttle],
    );
  await pad(0, 0, 0);
  await drawn(page); // it is seen at rest first
  await pad(-0.7, 0, 1);
  await until("all of the throttle", async () => (await value(page, "throttle")) === 1);
  await resume(page);
  await motion.until("to the left, faster", () => motion.turned > 0.4 && motion.speed > 5.5);
  await pad(0, 1, 0);
  await motion.until("it stands", () => motion.stands);
  await pad(0, 0, 0);
  await drawn(page);
});

test("two viewers: one drives, the other sees it, asks, and drives then", quick, async ({ page, motion, browser, url }) => {
  await toStart(page, motion);
  const other = await looking(browser, url);
  await until("who looks on is told so", async () => /Another viewer is in control/.test(await textOf(other.page, ".control-words")));
  await driving(other.page, true, "s"); // without effect
  await driving(page, true, "w");
  await until("all of the throttle", async () => (await value(page, "throttle")) === 1);
  await resume(page);
  await other.motion.until("the other sees it drive", () => other.motion.speed > 6);
  await pause(page);
  await state(other.page, "Paused");
  const { steps } = await (await fetch(new URL("/status", url))).json();
  await until("both see the same", () => motion.steps === steps && other.motion.steps === steps);
  assert.deepEqual([other.motion.x, other.motion.y, other.motion.z], [motion.x, motion.y, motion.z]);
  await resume(page);
  await driving(other.page, false, "s");
  await driving(page, false, "w");
  await take(other.page).click();
  await page.getByRole("button", { name: "Hand over" }).click();
  await inControl(other.page);
  await driving(page, true, "w"); // without effect
  await driving(other.page, true, "s");
  await motion.until("it stands", () => motion.stands);
  await driving(other.page, false, "s");
  await driving(page, false, "w");
  assert.deepEqual(other.complaints.filter((text) => !/WebGL/.test(text)), []);
  await other.page.close();
  await until("free again", async () => /Nobody/.test(await textOf(page, ".control-words")));
});

test("a phone: fingers on the pads drive, steer and brake", quick, async ({ page, motion, browser, url }) => {
  await toStart(page, motion);
  await resume(page);
  await take(page).click();
  await until("free", async () => /Nobody/.test(await textOf(page, ".control-words")));
  const phone = await looking(browser, url, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  await take(phone.page).tap();
  await until("pads", async () => phone.page.locator(".pads").isVisible());
  const { time } = phone.motion;
  await phone.page.getByRole("button", { name: "Reset" }).tap();
  await phone.motion.until("the start", () => phone.motion.time < time);
  phone.motion.begin();
  const session = await phone.page.context().newCDPSession(phone.page);
  const touch = async (...fingers) => {
    const touchPoints = [];
    for (const [id, [pad, across, up]] of fingers.entries()) {
      const { left, bottom, width, height } = await phone.page.locator(`.pad.${pad}`).evaluate((one) => one.getBoundingClientRect().toJSON());
      touchPoints.push({ x: left + across * width, y: bottom - up * height, id });
    }
    await session.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints });
  };
  const release = () => session.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  await touch(["steering", 0.8, 0.5], ["throttle", 0.5, 0.95]);
  await phone.motion.until("to the right, faster", () => phone.motion.turned < -0.4 && phone.motion.speed > 5.5);
  await release();
  await touch(["brake", 0.5, 0.95]);
  await phone.motion.until("it stands", () => phone.motion.stands);
  await release();
  assert.deepEqual(phone.complaints.filter((text) => !/WebGL/.test(text)), []);
  await phone.page.close();
});

test("on a road that grips too well it rolls over, lies there, and is put back on its wheels", ["--set", "friction=1.5", "--set", "speed=10"], async ({ page, motion, url }) => {
  await holding(page, motion, [throttle, left]);
  await motion.until("it rolls over", () => Math.abs(motion.roll) > 1.3);
  await driving(page, false, "a");
  await driving(page, false, "w");
  const { time } = motion;
  await motion.until("the simulation goes on", () => motion.time > time + 2);
  await state(page, "Running");
  const { message } = await (await fetch(new URL("/status", url))).json();
  assert.equal(message, "");
  await holding(page, motion, [["s", "brake", 1]]);
  await motion.until("it stands on its wheels", () => motion.stands && Math.abs(motion.roll) < 0.02);
});

let failed = 0;
const browser = await launch(false);
const due = cases.filter(({ name }) => name.includes(wanted));
for (const options of new Set(due.map(({ options }) => options))) {
  const server = await serveModel(program, model, "--port", "0", ...options);
  const { page, motion, complaints } = await looking(browser, server.url, { viewport: { width: 1280, height: 900 } });
  for (const { name, run } of due.filter((one) => one.options === options)) {
    const start = performance.now();
    try {
      await run({ page, motion, browser, url: server.url });
      assert.deepEqual(complaints.splice(0).filter((text) => !/WebGL/.test(text)), [], "the page complains");
      console.log(`ok   ${name} (${((performance.now() - start) / 1000).toFixed(1)} s)`);
    } catch (error) {
      ++failed;
      const { looks, ...seen } = motion;
      console.log(`FAIL ${name}\n${error.stack ?? error}\n${JSON.stringify(seen)}`);
      await alone(page, browser);
      await handsOff(page);
    }
  }
  await page.close();
  await server.stop();
}
await browser.close();
process.exit(failed > 0 ? 1 : 0);
