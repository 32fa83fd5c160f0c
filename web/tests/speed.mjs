// CPU time of a step in WebAssembly (in Node, whose engine is that of Chromium) against the program's, alternately:
//   node tests/speed.mjs MIMBRE [MODEL...] [--rounds N]
import { build } from "esbuild";
import { execFileSync } from "node:child_process";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { gunzipSync } from "node:zlib";

const root = fileURLToPath(new URL("../..", import.meta.url));
const words = process.argv.slice(2);
const option = words.indexOf("--rounds");
const rounds = option < 0 ? 5 : Number(words.splice(option, 2)[1]);
const [program, ...given] = words;
const models = given.length > 0 ? given : ["tutorial/four-bar.yaml", "double-four-bar/mechanism.yaml", "iltis/suspension.yaml", "iltis/vehicle.yaml", "iltis/drive.yaml", "delta-robot/model.yaml"].map((name) => `examples/${name}`);
const seconds = 1; // of the simulation
const warm = 3; // s of the clock, in which the engine compiles with more and more optimisation, in threads that count too
const shortest = 0.2; // s of the clock, of a measurement

const mimbre = (...args) => execFileSync(resolve(program), args, { cwd: root, encoding: "utf8", maxBuffer: 1e8 });
const folder = await mkdtemp(join(tmpdir(), "mimbre-speed-"));
await build({ entryPoints: [join(root, "web/src/pageSolver.ts")], bundle: true, format: "esm", outfile: join(folder, "solver.mjs"), logLevel: "warning" });
const { Solver, beginning } = await import(pathToFileURL(join(folder, "solver.mjs")));
const least = (numbers) => Math.min(...numbers);

console.log(`µs a step, least of ${rounds} rounds over ${seconds} s: WebAssembly, program, ratio; ratios of the rounds`);
for (const model of models) {
  const file = join(folder, "page.html");
  mimbre("page", model, "-o", file, "--quiet", "--solver", "build/wasm/mimbre.wasm");
  const data = JSON.parse(/id="data">(.*?)<\/script>/s.exec(await readFile(file, "utf8"))[1]);
  const [wasm, bytes] = [data.wasm, data.model].map((text) => gunzipSync(Buffer.from(text, "base64")));
  const solver = Solver.open(wasm, bytes);
  const steps = Math.round(seconds / solver.stepSize);
  // The restart is left out: the program's time has no start of a run either, and that costs as much as many steps.
  const inBrowser = (duration = shortest) => {
    const begin = performance.now();
    let made = 0, microseconds = 0;
    do {
      solver.restore(beginning);
      const start = process.cpuUsage(); // as the program measures: the machine may have other work
      for (let k = 0; k < steps; ++k) if (solver.step() < 0) throw new Error(solver.text());
      const { user, system } = process.cpuUsage(start);
      microseconds += user + system;
      made += steps;
    } while (performance.now() - begin < 1e3 * duration);
    return microseconds / made;
  };
  const inProgram = () => JSON.parse(mimbre("bench", model, "--runs", "5", "--until", String(seconds), "--json")).models[0].microseconds_per_step;
  inBrowser(warm);
  const times = Array.from({ length: rounds }, () => [inBrowser(), inProgram()]);
  const [here, there] = [least(times.map(([one]) => one)), least(times.map(([, one]) => one))];
  const ratios = times.map(([one, other]) => one / other);
  console.log(`${model.padEnd(40)} ${here.toFixed(1).padStart(8)} ${there.toFixed(1).padStart(8)} ${(here / there).toFixed(2).padStart(6)}   ${least(ratios).toFixed(2)} to ${Math.max(...ratios).toFixed(2)}`);
}
await rm(folder, { recursive: true });
