#include "mimbre/page.h"

#include <filesystem>

#include "app/common.h"
#include "app/json.h"
#include "app/targets.h"
#include "app/terminal/busy.h"

/// mimbre page: a model as one HTML file that simulates it.
namespace mimbre::app {
namespace {

struct PageArguments {
  std::string model, output, wasm;
  std::vector<std::string> settings;
  int most_modes = 0;
  bool json = false, quiet = false;
};

int page(const PageArguments& arguments) {
  const LoadedModel loaded = load(arguments.model, arguments.settings, arguments.quiet, arguments.most_modes);
  const std::string output = !arguments.output.empty()
                                 ? arguments.output
                                 : std::filesystem::path(arguments.model).replace_extension(".html").string();
  require_not_read(arguments.model, loaded, output);
  if (!arguments.wasm.empty()) require_different(arguments.wasm, output);
  require_writable(output);
  {
    const Busy busy("assembling the mechanism", !arguments.quiet);
    write_page(loaded.model, output, arguments.wasm);
  }
  if (!arguments.quiet || arguments.json) print_data(made("page", output, arguments.json));
  return done;
}

}  // namespace

Command add_page(CommandLine& program) {
  Parser parser = program.add_command("page", "Make one HTML file that simulates a model in the browser");
  const auto a = std::make_shared<PageArguments>();
  parser.add_option("model", a->model, "Model file (YAML)").required().type_name("MODEL");
  parser.add_option("-o,--output", a->output, "The page; default: named after the model")
      .type_name("FILE.html");
  add_set_option(parser, a->settings);
  add_most_modes_option(parser, a->most_modes);
  parser.add_option("--solver", a->wasm, "The solver as WebAssembly; default: the one built in (`make page`)")
      .type_name("FILE.wasm");
  parser.add_flag("--json", a->json, "The answer as JSON");
  parser.add_flag("-q,--quiet", a->quiet, "No messages");
  parser.footer(
      "The page opens from a folder, without a server or a network. It can be driven as that of `mimbre "
      "live`.\n"
      "Example:\n  mimbre page examples/iltis/drive.yaml -o drive.html");
  return {parser, [a] { return page(*a); }};
}

}  // namespace mimbre::app
