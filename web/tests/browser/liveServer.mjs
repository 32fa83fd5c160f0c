// A server of the program's, and what tests of the live page do there again and again.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { resolve } from "node:path";
import { root } from "./browser.mjs";

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

export const say = (page, selector) => page.locator(selector).first().innerText();

/** Until it is so; polled, for a page that draws slowly does not tell every change at once. */
export async function until(what, condition, seconds = 20) {
  const end = performance.now() + 1000 * seconds;
  for (;;) {
    const seen = await condition();
    if (seen) return seen;
    if (performance.now() > end) assert.fail(`not within ${seconds} s: ${what}`);
    await new Promise((done) => setTimeout(done, 40));
  }
}

export const state = (page, word) => until(word, async () => (await say(page, ".pill")) === word);

export const take = (page) => page.locator(".take");

export async function inControl(page) {
  const words = await until("who had it has left", async () => /^(Take|Give).*/.exec(await say(page, ".take"))?.[0]);
  if (words === "Take control") await take(page).click();
  await until("control", async () => (await say(page, ".take")) === "Give control back");
}

export const driving = (page, on, name) => (on ? page.keyboard.down(name) : page.keyboard.up(name));

/** How often the mechanism is drawn within 5 s, and how often the browser asks for it. */
export async function rate(page) {
  const { drawn, asked, width, height } = await page.evaluate(
    () =>
      new Promise((done) => {
        const { canvas } = window.mimbreView;
        const counts = { drawn: 0, asked: 0, width: canvas.width, height: canvas.height };
        const stop = window.mimbreView.onDrawn(() => ++counts.drawn);
        const begun = performance.now();
        const each = () => {
          ++counts.asked;
          if (performance.now() - begun < 5000) return requestAnimationFrame(each);
          stop();
          const seconds = (performance.now() - begun) / 1000;
          done({ ...counts, drawn: counts.drawn / seconds, asked: counts.asked / seconds });
        };
        each();
      }),
  );
  return { drawn, asked, words: `${drawn.toFixed(1)} pictures a second of ${width} × ${height} pixels, of ${asked.toFixed(1)} that the browser asked for` };
}
