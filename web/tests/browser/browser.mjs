// A page in a headless Chromium, and the reports that are looked at in it.
import { execFile } from "node:child_process";
import { existsSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { join } from "node:path";
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

export async function launch() {
  const { chromium: engine } = await import("playwright-core");
  // WebGL by software: the pictures are the same on every machine.
  const args = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
  return engine.launch({ executablePath: chromium(), args });
}

/** Runs a model with `mimbre` and makes its page; `reports`: of which results. */
export class Reports {
  constructor(program, folder) {
    this.program = program;
    this.folder = folder;
  }

  at(name) {
    return join(this.folder, name);
  }

  async run(model, name, ...options) {
    await this.mimbre("run", model, "-o", this.at(`${name}.h5`), "-q", ...options);
    return this.at(`${name}.h5`);
  }

  async report(name, ...results) {
    await this.mimbre("report", ...results, "-o", this.at(`${name}.html`));
    return `file://${this.at(`${name}.html`)}`;
  }

  async mimbre(...words) {
    const { stderr } = await promisify(execFile)(this.program, words, { cwd: root });
    process.stderr.write(stderr);
  }
}

/** Opens a page; whatever its script complains of is kept in `complaints`. */
export async function open(browser, url, options = {}, before = undefined) {
  const page = await browser.newPage({ viewport: { width: 1400, height: 900 }, acceptDownloads: true, ...options });
  if (before) await page.addInitScript(before);
  const complaints = [];
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  await page.goto(url);
  await page.waitForSelector("main");
  return { page, complaints };
}

/** The 3D view draws, with all its shaders compiled. */
export const ready = (page) => page.waitForFunction(() => window.mimbreView.ready);

/** Two pictures: after which the animation has been updated to its present time, and drawn if it is ready. */
export const drawn = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done()))));
