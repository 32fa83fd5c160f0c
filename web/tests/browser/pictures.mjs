// The pictures of docs/: node pictures.mjs MIMBRE FOLDER. Each is a report page at a telling moment.
import { mkdtemp, rm, stat } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { drawn, launch, noBrowser, open, ready, Reports } from "./browser.mjs";

const [program, target] = process.argv.slice(2);
const most = 150_000; // bytes of a picture
const reason = await noBrowser();
if (reason !== "") {
  console.error(`pictures: ${reason}`);
  process.exit(1);
}

const folder = await mkdtemp(join(tmpdir(), "mimbre-pictures-"));
const reports = new Reports(program, folder);

/** Which model, and what is set on its page before the picture is taken. */
const pictures = [
  { name: "report", model: "examples/iltis/vehicle.yaml", time: 5.2, forces: "all" },
  { name: "suspension", model: "examples/iltis/suspension.yaml", time: 2.2, forces: "all", exaggerate: 20, through: true, tab: "Spectrum" },
  { name: "four-bar", model: "examples/tutorial/four-bar.yaml", time: 1.69, forces: "all", tab: "Table" },
  { name: "slider-crank", model: "examples/slider-crank/slider-crank.yaml", others: [["rigid", "--set", "rod=rigid"]], time: 0.181 },
  { name: "bricard", model: "examples/bricard/mechanism.yaml", time: 0.8, forces: "all", tab: "x–y" },
  { name: "spin-up", model: "examples/spin-up-beam/beam-2d.yaml", time: 8, tab: "x–y" },
];

const browser = await launch();
for (const { name, model, others = [], time, forces, exaggerate, through, tab } of pictures) {
  const results = await Promise.all([reports.run(model, name), ...others.map(([other, ...options]) => reports.run(model, `${name}-${other}`, ...options))]);
  const { page, complaints } = await open(browser, await reports.report(name, ...results), { viewport: { width: 1180, height: 760 } });
  await page.evaluate((t) => window.mimbreView.clock.set(t), time);
  // Through the slider, so that what it shows is what is drawn; its ends are 1 and 500.
  if (exaggerate)
    await page.getByLabel("Exaggerate", { exact: true }).evaluate((slider, factor) => {
      slider.value = String(Math.log(factor) / Math.log(500));
      slider.dispatchEvent(new Event("input"));
    }, exaggerate);
  if (forces) await page.getByLabel("Forces", { exact: true }).selectOption(forces);
  if (through) await page.getByLabel("See through solids").check();
  if (tab) await page.getByRole("tab", { name: tab }).click();
  await ready(page);
  await drawn(page);
  const path = join(target, `${name}.png`);
  await page.screenshot({ path });
  const { size } = await stat(path);
  console.log(`${path}: ${(size / 1000).toFixed(0)} kB`);
  if (size > most) throw new Error(`${path} has ${size} bytes, more than ${most}`);
  if (complaints.length > 0) throw new Error(complaints.join("\n"));
  await page.close();
}
await browser.close();
await rm(folder, { recursive: true });
