// The solver of `mimbre page` as a C++ source: node embedSolver.mjs SOLVER.wasm OUTPUT.cpp
import { readFile, writeFile } from "node:fs/promises";
import { gzipSync } from "node:zlib";

const [, , wasm, output] = process.argv;
const text = gzipSync(await readFile(wasm), { level: 9 }).toString("base64");
const pieces = text.match(/.{1,8000}/g).map((piece) => `"${piece}"`);
await writeFile(
  output,
  `#include "live/page_solver.h"

namespace {
constexpr char solver[] =
${pieces.join("\n")};
}

std::string_view mimbre::live::page_solver() { return {solver, sizeof solver - 1}; }
`,
);
