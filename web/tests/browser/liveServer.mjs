// A server of the program's, and what tests of the live page do there again and again.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { createServer } from "node:net";
import { resolve } from "node:path";
import { root } from "./browser.mjs";

/** s that is waited for what has to come: much, for the machine may have other work, and what is asserted is that it comes. */
const patience = 300;

/** `mimbre live` with a model; says its address on its first line. */
export async function serveModel(program, model, ...options) {
  const child = spawn(resolve(program), ["live", model, "--no-open", "--quiet", ...options], { cwd: root, stdio: ["ignore", "pipe", "inherit"] });
  const url = await new Promise((done, failed) => {
    let said = "";
    child.stdout.on("data", (data) => {
      said += data;
      const found = /http:\/\/\S+/.exec(said);
      if (found) done(found[0]);
    });
    child.on("exit", (code) => failed(new Error(`mimbre live ended with ${code}`)));
  });
  const stop = () =>
    new Promise((done) => {
      child.on("exit", done);
      child.kill("SIGINT");
    });
  return { url, stop, port: Number(new URL(url).port) };
}

/** A port for a server that comes back to it: below those that systems give to whoever asks for any. */
export async function lastingPort() {
  for (let attempt = 0; ; ++attempt) {
    const port = 20_000 + Math.floor(12_000 * Math.random());
    const probe = createServer();
    const error = await new Promise((done) => {
      probe.once("error", done);
      probe.listen(port, "127.0.0.1", () => done(null));
    });
    if (!error) return new Promise((done) => probe.close(() => done(port)));
    if (attempt === 50) throw error;
  }
}

export const textOf = (page, selector) => page.locator(selector).first().innerText();

/** Until it is so; polled, for a page that draws slowly does not tell every change at once. */
export async function until(what, condition, seconds = patience) {
  const end = performance.now() + 1000 * seconds;
  for (;;) {
    const seen = await condition();
    if (seen) return seen;
    if (performance.now() > end) assert.fail(`not within ${seconds} s: ${what}`);
    await new Promise((done) => setTimeout(done, 40));
  }
}

export const state = (page, word) => until(word, async () => (await textOf(page, ".pill")) === word);

export const take = (page) => page.locator(".take");

export async function inControl(page) {
  const words = await until("who had it has left", async () => /^(Take|Release).*/.exec(await textOf(page, ".take"))?.[0]);
  if (words === "Take control") await take(page).click();
  await until("control", async () => (await textOf(page, ".take")) === "Release control");
}

const held = new WeakMap(); // keys that are down, by page

export async function driving(page, on, name) {
  if (!held.has(page)) held.set(page, new Set());
  if (on) held.get(page).add(name);
  else held.get(page).delete(name);
  await (on ? page.keyboard.down(name) : page.keyboard.up(name));
}

/** Nobody touches keys or pads, and nobody types, whatever a case that failed has left. */
export async function handsOff(page) {
  for (const name of [...(held.get(page) ?? [])]) await driving(page, false, name);
  await page.evaluate(() => {
    navigator.getGamepads = () => [];
    document.activeElement.blur(); // where one types, keys are letters
  });
}

/** Closes the other viewers that a case that failed has left. */
export async function alone(page, browser) {
  for (const context of browser.contexts()) if (context !== page.context()) await context.close();
}

export async function pause(page) {
  if ((await textOf(page, ".pill")) === "Running") await page.keyboard.press("p");
  await state(page, "Paused");
}

export async function resume(page) {
  await page.keyboard.press("p");
  await state(page, "Running");
}

/**
 * How often the mechanism is drawn within 5 s or five times, whichever takes longer, and how often the browser asks for it;
 * and how many of the moments that the view was brought to were not drawn.
 */
export async function rate(page) {
  const { drawn, asked, leftOut, width, height } = await page.evaluate(
    () =>
      new Promise((done) => {
        const { canvas, clock } = window.mimbreView;
        const [pictures, moments] = [[], []]; // the clock's times: drawn, and whenever the browser asks
        const stop = window.mimbreView.onDrawn(() => pictures.push(clock.time));
        const begun = performance.now();
        const each = () => {
          moments.push(clock.time);
          const seconds = (performance.now() - begun) / 1000;
          if (seconds < 5 || (pictures.length < 5 && seconds < 300)) return requestAnimationFrame(each);
          stop();
          const known = new Set([moments[0], ...pictures]);
          done({ drawn: pictures.length / seconds, asked: moments.length / seconds, leftOut: moments.filter((time) => !known.has(time)).length, width: canvas.width, height: canvas.height });
        };
        each();
      }),
  );
  return { drawn, leftOut, words: `${drawn.toFixed(1)} pictures a second of ${width} × ${height} pixels, of ${asked.toFixed(1)} that the browser asked for` };
}
