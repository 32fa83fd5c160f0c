#include "app/common.h"
#include "app/json.h"
#include "app/terminal/progress.h"
#include "mimbre/vtk.h"

/// mimbre export: a run for other programs that draw.
namespace mimbre::app {
namespace {

struct ExportArguments {
  std::string results, folder;
  int instants = 500;
  bool json = false;
};

int run_export(const ExportArguments& a) {
  const Results results = read_results(a.results);
  Progress progress(!a.json);
  VtkOptions options;
  options.most_instants = a.instants;
  options.progress = [&](double part) { progress.update("writing", part); };
  const std::string path = write_vtk(results, a.folder, options);
  progress.clear();
  print_data(made("export", path, a.json));
  return done;
}

}  // namespace

Command add_export(CommandLine& program) {
  Parser parser =
      program.add_command("export", "Write a run as VTK files: motion, deflection and stress for ParaView");
  const auto a = std::make_shared<ExportArguments>();
  parser.add_option("results", a->results, "Results file (HDF5)").required().type_name("RESULTS.h5");
  parser.add_option("--vtk", a->folder, "Folder for the files").required().type_name("FOLDER");
  parser.add_option("--instants", a->instants, "At most so many instants, evenly spread; default 500")
      .within(2, 1000000);
  parser.add_flag("--json", a->json, "The name as JSON");
  parser.footer(
      "Prints the name of the file to open. An older export in the folder is replaced at the end, all of it; "
      "other "
      "files stay.\nExample:\n  mimbre export run.h5 --vtk frames\n"
      "  paraview frames/run.pvd");
  return {parser, [a] { return run_export(*a); }};
}

}  // namespace mimbre::app
