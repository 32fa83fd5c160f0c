// Bundles each page into one HTML file: dist/report.html, dist/live.html, dist/model.html.
//   node build.mjs                the pages
//   node build.mjs --cpp FOLDER   also each page as a C++ source there: report_page.cpp, live_page.cpp, model_page.cpp
//   node build.mjs --tests        the tests instead, for node --test
import { build } from "esbuild";
import { mkdir, readdir, readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";

const placeholder = "%MIMBRE_DATA%";

/** `data`: how often the placeholder stands in it; `header` and `defines`: of the C++ source. */
const pages = {
  report: { entry: "src/main.ts", template: "src/template.html", data: 1, header: "results/report_page.h", defines: "mimbre::results::report_page" },
  model: { entry: "src/page.ts", template: "src/pageTemplate.html", worker: "src/pageWorker.ts", data: 1, header: "live/live_page.h", defines: "mimbre::live::model_page" },
  live: { entry: "src/live.ts", template: "src/liveTemplate.html", data: 0, header: "live/live_page.h", defines: "mimbre::live::live_page" },
};

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

async function page({ entry, template: file, worker, data }) {
  const { script, style } = await bundle(entry, true);
  const code = worker ? (await bundle(worker, true)).script : "";
  if (/<\/script|<!--/i.test(script + code) || /<\/style/i.test(style)) throw new Error("the bundle would end its element");
  const template = await readFile(file, "utf8");
  // Functions as replacements: "$" in the bundle means nothing then.
  const parts = { "<!--LICENCES-->": await licences(), "/*STYLE*/": style, "/*SCRIPT*/": script, "/*WORKER*/": code };
  const html = Object.entries(parts).reduce((text, [mark, part]) => text.replace(mark, () => part), template);
  if (html.split(placeholder).length !== 1 + data) throw new Error(`${file} with its bundle must hold ${placeholder} ${data} times`);
  return html;
}

/** Raw string literals of moderate length: compilers read them fast and none has a limit that they reach. */
function cpp(html, { header, defines }) {
  const pieces = [];
  for (let at = 0; at < html.length; ) {
    let end = Math.min(at + 8000, html.length);
    // A character outside the basic plane must not be cut in two.
    if (end < html.length && (html.charCodeAt(end - 1) & 0xfc00) === 0xd800) --end;
    pieces.push(`R"mimbrepage(${html.slice(at, end)})mimbrepage"`);
    at = end;
  }
  return `#include "${header}"

namespace {
constexpr char page[] =
${pieces.join("\n")};
}

std::string_view ${defines}() { return {page, sizeof page - 1}; }
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
  await mkdir("dist", { recursive: true });
  for (const [name, made] of Object.entries(pages)) {
    const html = await page(made);
    await writeFile(`dist/${name}.html`, html);
    if (mode === "--cpp") await writeFile(join(output, `${name}_page.cpp`), cpp(html, made));
  }
}
