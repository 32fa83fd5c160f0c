#include "mimbre/fmu.h"

#include <fmt/format.h>

#include "app/common.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/targets.h"

/// mimbre fmu: a model for other simulation programs.
namespace mimbre::app {
namespace {

struct FmuArguments {
  std::string model, file, version = "3", kind = "cs";
  FmuOptions fmu;
  std::vector<std::string> settings;
  RunOptions method;
  bool json = false;
};

int run_fmu(const FmuArguments& a) {
  const LoadedModel loaded = load(a.model, a.settings);
  require_not_read(a.model, loaded, a.file);
  require_writable(a.file);
  FmuOptions fmu = a.fmu;
  fmu.version = a.version == "2" ? 2 : 3;
  fmu.kind = a.kind == "me" ? FmuOptions::Kind::model_exchange : FmuOptions::Kind::co_simulation;
  if (fmu.name.empty()) fmu.name = identifier_of(a.model);
  fmu.settings = overrides(a.settings);
  const RunOptions method = run_options(a.method, loaded.model->spec().simulation);
  const WrittenFmu written = write_fmu(loaded.model, method, fmu, a.file);
  for (const std::string& output : written.left_out)
    print_warning(fmt::format("output {} is not in the FMU", output));
  if (!written.without_binary.empty())
    print_warning(fmt::format("the FMU has sources alone, and no binary: {}", written.without_binary));
  print_data(made("fmu", a.file, a.json));
  return done;
}

}  // namespace

Command add_fmu(CommandLine& program) {
  Parser parser = program.add_command("fmu", "Write an FMU: the model for other simulation programs");
  const auto a = std::make_shared<FmuArguments>();
  parser.add_option("model", a->model, "Model file (YAML)").required().type_name("MODEL");
  parser.add_option("-o,--output", a->file, "File of the FMU").required().type_name("FILE.fmu");
  parser.add_option("--fmi", a->version, "Version of the standard").choice({"2", "3"}).show_default();
  parser.add_option("--kind", a->kind, "Of FMU: cs, for co-simulation, or me, for model exchange")
      .choice({"cs", "me"})
      .show_default();
  parser.add_option("--name", a->fmu.name, "Model identifier; default: the model file's name")
      .type_name("NAME");
  parser.add_flag("--binary-only", a->fmu.binary_only, "Without the sources");
  parser.add_flag(
      "--library", a->fmu.with_library,
      "With the library inside in place of code for the model: for\nwhatever a run takes; a binary "
      "alone");
  parser.add_flag("--arrays", a->fmu.arrays,
                  "Of FMI 3: outputs that are all components of a vector\nas one array: tip in place of "
                  "tip.x, tip.y, tip.z");
  add_set_option(parser, a->settings);
  parser.add_flag("--json", a->json, "The name of the file as JSON");
  add_method_options(parser, a->method);
  parser.footer(
      "Steps for co-simulation are those of `mimbre run --fixed-cost`; for model exchange the importer's "
      "solver "
      "makes the steps (docs/fmu.md). With --library they are those of `mimbre run`. The sources are "
      "compiled "
      "with `cc`, or what CC names.\nExample:\n  mimbre fmu suspension.yaml -o suspension.fmu --fmi 3");
  return {parser, [a] { return run_fmu(*a); }};
}

}  // namespace mimbre::app
