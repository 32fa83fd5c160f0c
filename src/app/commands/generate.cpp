#include <fmt/format.h>

#include <filesystem>

#include "app/common.h"
#include "app/json.h"
#include "app/method_options.h"
#include "app/targets.h"
#include "mimbre/generate.h"

/// mimbre generate: C99 for one model.
namespace mimbre::app {
namespace {

struct GenerateArguments {
  std::string model, folder, name;
  std::vector<std::string> settings;
  RunOptions method;
  bool json = false;
};

/// The folder is made if there is none.
void check_files(const GenerateArguments& a, const LoadedModel& loaded, const std::string& name) {
  std::error_code unknown;
  const std::filesystem::path folder = a.folder;
  for (const char* end : {".h", ".c"}) {
    const std::string path = (folder / (name + end)).string();
    require_not_read(a.model, loaded, path);
    if (std::filesystem::is_directory(folder, unknown)) require_writable(path);
  }
}

int run_generate(const GenerateArguments& a) {
  const LoadedModel loaded = load(a.model, a.settings);
  const std::string name = a.name.empty() ? identifier_of(a.model) : a.name;
  check_files(a, loaded, name);
  const GeneratedCode code =
      generate_code(loaded.model, run_options(a.method, loaded.model->spec().simulation), name);
  try {
    write_code(code, a.folder);
  } catch (const InputError& error) {
    throw Failure(error.what());
  }
  for (const std::string& output : code.left_out)
    print_warning(fmt::format("output {} is not in the code", output));
  const std::string path = (std::filesystem::path(a.folder) / (name + ".c")).string();
  print_data(made("generate", path, a.json));
  return done;
}

}  // namespace

Command add_generate(CommandLine& program) {
  Parser parser = program.add_command("generate", "Write C99 that steps the model, without any library");
  const auto a = std::make_shared<GenerateArguments>();
  parser.add_option("model", a->model, "Model file (YAML)").required().type_name("MODEL");
  parser.add_option("-o,--output", a->folder, "Folder for NAME.h and NAME.c").required().type_name("DIR");
  parser.add_option("--name", a->name, "Of the files and of all in them; default: the model file's")
      .type_name("NAME");
  add_set_option(parser, a->settings);
  parser.add_flag("--json", a->json, "The name of the source file as JSON");
  add_method_options(parser, a->method);
  parser.footer(
      "Steps are those of `mimbre run --fixed-cost` (docs/generated-code.md).\nExample:\n  mimbre generate "
      "suspension.yaml -o code\n  cc -O2 -c code/suspension.c");
  return {parser, [a] { return run_generate(*a); }};
}

}  // namespace mimbre::app
