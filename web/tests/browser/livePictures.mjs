// The pictures of the live page in docs/: node livePictures.mjs MIMBRE FOLDER. The vehicle is driven over the hill to the stairs.
import { stat } from "node:fs/promises";
import { join } from "node:path";
import { launch, noBrowser, open, ready } from "./browser.mjs";
import { driving, inControl, rate, serveModel, take, until } from "./liveServer.mjs";

const [program, target] = process.argv.slice(2);
const most = 300_000; // bytes of a picture
const reason = await noBrowser();
if (reason !== "") {
  console.error(`pictures: ${reason}`);
  process.exit(1);
}

const server = await serveModel(program, "examples/iltis/drive.yaml", "--port", "0", "--priority", "50"); // drawing takes every processor
const browser = await launch();

/** Of the first channels, as the legends have them. */
async function reading(page, name) {
  const text = await page.locator(".strips .entry", { hasText: new RegExp(`^${name}`) }).locator(".value").innerText();
  return Number.parseFloat(text.replace("−", "-"));
}

async function save(page, name) {
  // Drawn with everything, however slowly.
  await page.evaluate(() => {
    window.mimbreView.refine(true);
    window.mimbreView.redraw();
  });
  const path = join(target, `${name}.png`);
  await page.screenshot({ path });
  const { size } = await stat(path);
  console.log(`${path}: ${(size / 1000).toFixed(0)} kB`);
  if (size > most) throw new Error(`${path} has ${size} bytes, more than ${most}`);
}

/** On at some 7 m/s, until it is that far. */
async function driveTo(page, place, seconds = 120) {
  await until(`x = ${place} m`, async () => {
    await driving(page, (await reading(page, "speed")) < 7, "w");
    return (await reading(page, "x")) > place;
  }, seconds);
}

{
  const { page } = await open(browser, `${server.url}#color=stress`, { viewport: { width: 1360, height: 1110 } });
  await ready(page);
  await inControl(page);
  await page.keyboard.press("r");
  await until("the start", async () => (await reading(page, "x")) < 12);
  await page.evaluate(() => {
    window.mimbreView.seeThrough(true);
    window.mimbreView.turn(-0.8, -0.05, 0.85);
  });
  await driveTo(page, 16);
  const { words } = await rate(page);
  console.log(words);
  await page.keyboard.press("r");
  await until("the start again", async () => (await reading(page, "x")) < 12);
  await driveTo(page, 16);
  const steering = page.getByLabel("steering, as a number");
  for (const [key, steered] of [["a", (value) => value > 0.1], ["d", (value) => value < -0.05]]) {
    await driving(page, true, key);
    await until(key, async () => steered(Number(await steering.inputValue())));
    await driving(page, false, key);
  }
  await driveTo(page, 36);
  await save(page, "live");
  await take(page).click();
  await page.close();
}
{
  const { page } = await open(browser, server.url, { viewport: { width: 390, height: 780 }, deviceScaleFactor: 1.5, hasTouch: true, isMobile: true });
  await ready(page);
  await until("nobody else drives", async () => (await take(page).innerText()) === "Take control");
  await take(page).tap();
  await until("pads", async () => page.locator(".pads").isVisible());
  await page.getByRole("button", { name: "Reset" }).tap();
  await until("on its way", async () => (await reading(page, "x")) > 1);
  await until("hands on", async () => page.locator(".pads").isVisible());
  const session = await page.context().newCDPSession(page);
  const touchPoints = [];
  for (const [id, [pad, across, up]] of [["steering", 0.38, 0.5], ["throttle", 0.5, 0.6]].entries()) {
    const { left, bottom, width, height } = await page.locator(`.pad.${pad}`).evaluate((one) => one.getBoundingClientRect().toJSON());
    touchPoints.push({ x: left + across * width, y: bottom - up * height, id });
  }
  await session.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints });
  await until("on the hill", async () => (await reading(page, "x")) > 16, 60);
  await save(page, "live-phone");
  await page.close();
}
await browser.close();
await server.stop();
