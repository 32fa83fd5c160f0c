#include <fmt/format.h>

#include <filesystem>

#include "app/common.h"
#include "app/json.h"
#include "app/targets.h"
#include "mimbre/fe_import.h"

/// mimbre convert: a reduced body from one format to another.
namespace mimbre::app {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string input, output, to;
  bool no_stress = false, json = false;
};

fe::BodyFormat format_of(const std::string& path) {
  try {
    return fe::body_format(path);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
}

int run(const Arguments& a) {
  format_of(a.input);
  const std::string output =
      a.output.empty() ? fs::path(a.input).replace_extension("." + a.to).string() : a.output;
  require_different(a.input, output);
  a.to == "h5" ? require_writable_body(output) : require_writable(output);
  fe::ImportedBody read = fe::read_body(a.input);
  for (const Diagnostic& warning : read.warnings)
    fmt::print(stderr, "{}\n", diagnostic_line(warning, "warning"));
  if (a.no_stress) {
    read.body.stress.resize(0, 0);
    read.body.strain.resize(0, 0);
  }
  if (read.body.name.empty()) read.body.name = fs::path(a.input).stem().string();
  try {
    fe::write_body(read.body, output, fe::body_format("body." + a.to));
  } catch (const std::invalid_argument& error) {
    throw InputError(Mark{a.input}, error.what());
  }
  print_data(made("convert", output, a.json));
  return done;
}

}  // namespace

Command add_convert(CommandLine& program) {
  Parser parser =
      program.add_command("convert", "Write a reduced body in another format: MBDyn's .fem, SID, HDF5");
  const auto a = std::make_shared<Arguments>();
  parser.add_option("body", a->input, "Reduced body: .h5, .fem or .sid").required().type_name("BODY");
  parser.add_option("--to", a->to, "Format to write").required().choice({"sid", "fem", "h5"});
  parser.add_flag("--no-stress", a->no_stress,
                  "Leave stress out: in SID every point with stress is a node more");
  parser.add_option("-o,--output", a->output, "File to write; default: the input's name with the new ending")
      .type_name("FILE");
  parser.add_flag("--json", a->json, "The file's name as JSON");
  parser.footer(
      "Prints the file's name. What a format has no place for is said in docs/reduced-body-format.md.\n"
      "Example:\n  mimbre convert arm.h5 --to fem");
  return {parser, [a] { return run(*a); }};
}

}  // namespace mimbre::app
