// Bundles the page into one HTML file: dist/report.html.
//   node build.mjs              the page
//   node build.mjs --cpp FILE   also the page as a C++ source that defines mimbre::results::report_page()
//   node build.mjs --tests      the tests instead, for node --test
import { build } from "esbuild";
import { mkdir, readdir, readFile, writeFile } from "node:fs/promises";

const placeholder = "%MIMBRE_DATA%";

async function bundle(entry, minify) {
  const result = await build({
    entryPoints: [entry],
    bundle: true,
    write: false,
    outdir: "dist",
    minify,
    format: "iife",
    target: "es2020",
    charset: "utf8",
    legalComments: "none",
    logLevel: "warning",
  });
  const text = (ending) => result.outputFiles.find((file) => file.path.endsWith(ending))?.text ?? "";
  return { script: text(".js"), style: text(".css") };
}

/** The licences of what is bundled ask to go with every copy. */
async function licences() {
  const texts = await Promise.all(
    ["three", "uplot"].map(async (name) => `${name}\n\n${await readFile(`node_modules/${name}/LICENSE`, "utf8")}`),
  );
  return `<!--\nThis page contains the following software.\n\n${texts.join("\n\n").trim().replaceAll("--", "- -")}\n-->`;
}

async function page() {
  const { script, style } = await bundle("src/main.ts", true);
  if (/<\/script|<!--/i.test(script) || /<\/style/i.test(style)) throw new Error("the bundle would end its element");
  const template = await readFile("src/template.html", "utf8");
  // Functions as replacements: "$" in the bundle means nothing then.
  const parts = { "<!--LICENCES-->": await licences(), "/*STYLE*/": style, "/*SCRIPT*/": script };
  const html = Object.entries(parts).reduce((text, [mark, part]) => text.replace(mark, () => part), template);
  if (html.split(placeholder).length !== 2) throw new Error(`the page must hold ${placeholder} exactly once`);
  return html;
}

/** Raw string literals of moderate length: compilers read them fast and none has a limit that they reach. */
function cpp(html) {
  const pieces = [];
  for (let at = 0; at < html.length; ) {
    let end = Math.min(at + 8000, html.length);
    // A character outside the basic plane must not be cut in two.
    if (end < html.length && (html.charCodeAt(end - 1) & 0xfc00) === 0xd800) --end;
    pieces.push(`R"mimbrepage(${html.slice(at, end)})mimbrepage"`);
    at = end;
  }
  return `#include "results/report_page.h"

namespace {
constexpr char page[] =
${pieces.join("\n")};
}

std::string_view mimbre::results::report_page() { return {page, sizeof page - 1}; }
`;
}

const [mode, output] = process.argv.slice(2);
if (mode === "--tests") {
  await build({
    entryPoints: (await readdir("tests")).filter((name) => name.endsWith(".test.ts")).map((name) => `tests/${name}`),
    bundle: true,
    outdir: "dist/tests",
    outExtension: { ".js": ".mjs" },
    platform: "node",
    format: "esm",
    logLevel: "warning",
  });
} else {
  const html = await page();
  await mkdir("dist", { recursive: true });
  await writeFile("dist/report.html", html);
  if (mode === "--cpp") await writeFile(output, cpp(html));
}
