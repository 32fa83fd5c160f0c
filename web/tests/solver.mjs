// The examples by the solver as WebAssembly (in Node, whose engine is that of Chromium) and by the program: every channel of
// `mimbre run` at every step. node tests/solver.mjs MIMBRE ["MODEL OPTIONS"...]. Exits with 77 where there is no solver.
import { build } from "esbuild";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { mkdtemp, readFile, readdir, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { gunzipSync } from "node:zlib";

const root = fileURLToPath(new URL("../..", import.meta.url));
const wasm = join(root, "build/wasm/mimbre.wasm");
if (!existsSync(wasm)) {
  console.log("SKIPPED: no solver for pages; make page builds it");
  process.exit(77);
}
const [, , program, ...given] = process.argv;
const steps = 100;
/** Of the largest value of the channels of the same unit. Forces and accelerations differ by round-off of positions, over the square of the step. */
const tolerance = (unit) => (["m", "rad"].includes(unit) ? 1e-7 : 1e-5);
const variants = ["elastodynamics", "geometric_stiffness", "ancf"].map((approach) => `examples/slider-crank/slider-crank.yaml --set approach=${approach}`);
const floor = 1e-3; // m, rad, ...: smaller values count as this, where nothing but round-off moves

const mimbre = (...args) => execFileSync(resolve(program), args, { cwd: root, encoding: "utf8", maxBuffer: 1e8, stdio: ["ignore", "pipe", "pipe"] });
const folder = await mkdtemp(join(tmpdir(), "mimbre-solver-"));
await build({ entryPoints: [join(root, "web/src/pageSolver.ts")], bundle: true, format: "esm", outfile: join(folder, "solver.mjs"), logLevel: "warning" });
const { Solver } = await import(pathToFileURL(join(folder, "solver.mjs")));

/** Models: not the parts that files beside them include, nor lists of runs. */
async function examples() {
  const files = (await readdir(join(root, "examples"), { recursive: true })).filter((name) => name.endsWith(".yaml")).map((name) => `examples/${name}`);
  const texts = await Promise.all(files.map((file) => readFile(join(root, file), "utf8")));
  const parts = texts.flatMap((text, k) => [...text.matchAll(/(?:include|file): *([\w./-]+\.yaml)/g)].map(([, part]) => join(dirname(files[k]), part)));
  return files.filter((file, k) => !parts.includes(file) && /^mimbre:/m.test(texts[k]) && /^title:/m.test(texts[k])).sort();
}

/** The largest difference of a channel over the run, by the largest value of its unit and the tolerance, and which channel it is. */
async function apart(line) {
  const [model, ...options] = line.split(" ");
  const page = join(folder, "page.html"), table = join(folder, "run.csv");
  mimbre("page", model, ...options, "-o", page, "--quiet", "--solver", wasm);
  const data = JSON.parse(/id="data">(.*?)<\/script>/s.exec(await readFile(page, "utf8"))[1]);
  const solver = Solver.open(gunzipSync(Buffer.from(data.wasm, "base64")), gunzipSync(Buffer.from(data.model, "base64")));
  mimbre("run", model, ...options, "--until", String(steps * solver.stepSize), "--csv", table, "--quiet");
  const [head, ...rows] = (await readFile(table, "utf8")).trim().split("\n").map((line) => line.split(","));
  const { channels } = data.scene, names = channels.map(({ name }) => name);
  const columns = head.slice(1).map((name, k) => ({ name, k: k + 1, channel: names.indexOf(name), largest: 0, difference: 0 }));
  if (columns.length === 0 || columns.some(({ channel }) => channel < 0)) throw new Error(`columns ${head} among the channels ${names}`);
  let compared = 0;
  for (const row of rows) {
    while (Number(row[0]) > solver.time + 0.5 * solver.stepSize) if (solver.step() < 0) throw new Error(solver.text());
    if (Math.abs(Number(row[0]) - solver.time) > 1e-9) continue; // of an event, between steps
    ++compared;
    for (const column of columns) {
      const there = Number(row[column.k]), here = solver.channel(column.channel);
      if (Number.isNaN(there) && Number.isNaN(here)) continue;
      column.largest = Math.max(column.largest, Math.abs(there));
      column.difference = Math.max(column.difference, Math.abs(here - there));
      if (!(Math.abs(here - there) < Infinity)) column.difference = Infinity;
    }
  }
  if (compared < 2) throw new Error(`${compared} instants were compared`);
  const scale = (unit) => Math.max(...columns.filter(({ channel }) => channels[channel].unit === unit).map(({ largest }) => largest), floor);
  const shares = columns.map(({ name, channel, difference }) => {
    const { unit } = channels[channel];
    return { name, share: difference / scale(unit) / tolerance(unit) };
  });
  return shares.reduce((worst, one) => (one.share > worst.share ? one : worst));
}

const models = given.length > 0 ? given : [...(await examples()), ...variants];
let failed = 0;
for (const model of models) {
  try {
    const { name, share } = await apart(model);
    if (!(share < 1)) ++failed;
    console.log(`${share < 1 ? "ok  " : "FAIL"} ${model.padEnd(76)} ${share.toExponential(1)} of the tolerance: ${name}`);
  } catch (error) {
    ++failed;
    console.log(`FAIL ${model}: ${error.stderr ?? error.message}`);
  }
}
await rm(folder, { recursive: true });
console.log(`${models.length - failed} passed, ${failed} failed`);
process.exit(failed === 0 && models.length > 0 ? 0 : 1);
