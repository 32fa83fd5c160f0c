// A page in a headless Chromium, and the reports that are looked at in it.
import { execFile } from "node:child_process";
import { existsSync } from "node:fs";
import { writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { join, resolve } from "node:path";
import { promisify } from "node:util";

export const root = fileURLToPath(new URL("../../..", import.meta.url));

/** Why there is no browser; "" where there is one. */
export async function noBrowser() {
  if (!chromium()) return "no Chromium (Debian: apt-get install chromium)";
  try {
    await import("playwright-core");
  } catch {
    return "no playwright-core (npm ci in web/)";
  }
  return "";
}

const chromium = () => [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser"].find((path) => path && existsSync(path));

/** WebGL by software: the pictures are the same on every machine. */
const bySoftware = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

/** `webgl`: false for pages whose pictures do not matter, which are much quicker without. */
export async function launch(webgl = true) {
  const { chromium: engine } = await import("playwright-core");
  return engine.launch({ executablePath: chromium(), args: ["--no-sandbox", ...(webgl ? bySoftware : ["--disable-3d-apis"])] });
}

/** Runs a model with `mimbre` and makes its page; `reports`: of which results. */
export class Reports {
  constructor(program, folder) {
    this.program = resolve(program);
    this.folder = folder;
  }

  at(name) {
    return join(this.folder, name);
  }

  async run(model, name, ...options) {
    await this.mimbre("run", model, "-o", this.at(`${name}.h5`), "-q", ...options);
    return this.at(`${name}.h5`);
  }

  /** With the summary that a comparison shows. */
  async timed(model, name, ...options) {
    const results = this.at(`${name}.h5`);
    const summary = this.at(`${name}.json`);
    // A run may fail, and is compared all the same.
    const { stdout } = await this.mimbre("run", model, "-o", results, "-q", "--json", ...options).catch((error) => error);
    await writeFile(summary, stdout);
    return { results, summary };
  }

  async comparison(name, runs) {
    await this.mimbre("report", ...runs.map(({ results }) => results), "-o", this.at(`${name}.html`), ...runs.flatMap(({ label, summary }) => ["--label", label, "--summary", summary]));
    return `file://${this.at(`${name}.html`)}`;
  }

  async report(name, ...results) {
    await this.mimbre("report", ...results, "-o", this.at(`${name}.html`));
    return `file://${this.at(`${name}.html`)}`;
  }

  async mimbre(...words) {
    const { stdout, stderr } = await promisify(execFile)(this.program, words, { cwd: root });
    process.stderr.write(stderr);
    return { stdout };
  }
}

/** Of a report that does not play by itself: what is read from it does not change meanwhile. */
export const resting = { reducedMotion: "reduce" };

/** Opens a page; whatever its script complains of is kept in `complaints`. `listen` gets the page before it is loaded. */
export async function open(browser, url, options = {}, before = undefined, listen = undefined) {
  const page = await browser.newPage({ viewport: { width: 1000, height: 640 }, acceptDownloads: true, ...options });
  page.setDefaultTimeout(300_000); // a machine that has other work takes its time
  if (before) await page.addInitScript(before);
  const complaints = [];
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  listen?.(page);
  await page.goto(url);
  await page.waitForSelector("main");
  return { page, complaints };
}

/** The 3D view draws, with all its shaders compiled. */
export const ready = (page) => page.waitForFunction(() => window.mimbreView?.ready);

/** Two pictures: after which the animation has been updated to its present time, and drawn if it is ready. */
export const drawn = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done()))));
