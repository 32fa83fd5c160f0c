// What passes until a report's first picture: node opening.mjs MIMBRE [MODEL]. Marks of the page itself, in ms since the browser
// began to load it; the least of several times, since other work on the machine only adds. WebGL is drawn by software.
import { mkdtemp, rm, stat } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { drawn, launch, noBrowser, open, ready, Reports, resting } from "./browser.mjs";

const [program, model = "examples/iltis/vehicle.yaml"] = process.argv.slice(2);
const times = 7;
const reason = await noBrowser();
if (reason !== "") {
  console.error(`opening: ${reason}`);
  process.exit(1);
}

const folder = await mkdtemp(join(tmpdir(), "mimbre-opening-"));
const reports = new Reports(program, folder);
const url = await reports.report("page", await reports.run(model, "run"));
const browser = await launch();

const stages = [
  ["read", "the file read, the script parsed"],
  ["parsed", "its JSON parsed"],
  ["decoded", "its arrays decoded"],
  ["built", "the page and the scene built"],
  ["compiled", "the shaders compiled"],
  ["drawn", "the first picture"],
];
const all = [];
for (let k = 0; k < times; ++k) {
  const { page } = await open(browser, url, { ...resting, viewport: { width: 1400, height: 900 } });
  await ready(page);
  await drawn(page);
  all.push(
    await page.evaluate(() => {
      const { canvas } = window.mimbreView;
      const pixel = new Uint8Array(4);
      const gl = canvas.getContext("webgl2");
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); // waits for the picture
      performance.mark("mimbre: drawn");
      return Object.fromEntries(performance.getEntriesByType("mark").map(({ name, startTime }) => [name.slice("mimbre: ".length), startTime]));
    }),
  );
  await page.close();
}
await browser.close();
console.log(`${model}: ${((await stat(reports.at("page.html"))).size / 1e6).toFixed(1)} MB, the least of ${times} times, ms`);
for (const [k, [mark, text]] of stages.entries()) {
  const at = Math.min(...all.map((marks) => marks[mark]));
  const own = Math.min(...all.map((marks) => marks[mark] - (k > 0 ? marks[stages[k - 1][0]] : 0)));
  console.log(`${text.padEnd(34)} ${own.toFixed(0).padStart(5)}   at ${at.toFixed(0).padStart(5)}`);
}
await rm(folder, { recursive: true });
