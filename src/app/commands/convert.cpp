#include <fmt/format.h>

#include <cctype>
#include <filesystem>
#include <map>

#include "app/advice.h"
#include "app/common.h"
#include "app/json.h"
#include "app/targets.h"
#include "mimbre/fe_import.h"
#include "mimbre/method_arguments.h"
#include "mimbre/simulation.h"
#include "mimbre/urdf.h"

/// mimbre convert: a reduced body from one format to another, a robot from URDF to a model file.
namespace mimbre::app {
namespace {

namespace fs = std::filesystem;

struct ConvertArguments {
  std::string input, output, to;
  std::vector<std::string> packages;
  bool no_stress = false, floating = false, keep_fixed = false, repair = false, json = false;
};

fe::BodyFormat format_of(const std::string& path) {
  try {
    return fe::body_format(path);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
}

/// NAME=FOLDER
std::map<std::string, std::string> packages_of(const ConvertArguments& a) {
  std::map<std::string, std::string> packages;
  for (const std::string& text : a.packages) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw UsageError(fmt::format("--package {}: NAME=FOLDER is needed", text));
    packages[text.substr(0, equals)] = text.substr(equals + 1);
  }
  return packages;
}

/// Prints the messages of `mimbre check`; whether it accepts the model.
bool accepted(const std::string& path) {
  try {
    const LoadedModel loaded = load(path, {}, true);
    const Simulation simulation(loaded.model, run_options({}, loaded.model->spec().simulation));
    print_advice(simulation);
    for (const std::string& warning : simulation.warnings()) print_warning(warning);
    return true;
  } catch (const InputError& error) {
    for (const Diagnostic& one : error.diagnostics())
      fmt::print(stderr, "{}\n", diagnostic_line(one, "error"));
  } catch (const std::exception& error) {
    print_error(error.what());
  }
  print_warning(fmt::format("{} is written, but `mimbre check` refuses it", path));
  return false;
}

int convert_robot(const ConvertArguments& a) {
  if (!a.to.empty() && a.to != "yaml")
    throw UsageError(fmt::format("a robot becomes a model file: --to yaml, not {}", a.to));
  if (a.no_stress) throw UsageError("--no-stress belongs to reduced bodies");
  const std::string output =
      a.output.empty() ? fs::path(a.input).replace_extension(".yaml").string() : a.output;
  require_different(a.input, output);
  require_writable(output);
  const fs::path folder = fs::path(output).parent_path();
  const ConvertedRobot robot = convert_urdf(
      a.input, {a.floating, a.keep_fixed, packages_of(a), folder.empty() ? "." : folder.string(), a.repair});
  for (const Diagnostic& note : robot.notes) fmt::print(stderr, "{}\n", diagnostic_line(note, "note"));
  for (const Diagnostic& one : robot.repairs) fmt::print(stderr, "{}\n", diagnostic_line(one, "repaired"));
  save(robot, output);
  print_data(made("convert", output, a.json));
  return accepted(output) ? done : warned;
}

int convert_body(const ConvertArguments& a) {
  if (a.to.empty()) throw UsageError("--to is needed: sid, fem or h5");
  if (a.to == "yaml") throw UsageError("--to yaml is for robots (.urdf)");
  if (a.floating || a.keep_fixed || a.repair || !a.packages.empty())
    throw UsageError("--floating, --keep-fixed, --repair and --package belong to robots (.urdf)");
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

int run_convert(const ConvertArguments& a) {
  std::string ending = fs::path(a.input).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending == ".urdf" || ending == ".xacro" ? convert_robot(a) : convert_body(a);
}

}  // namespace

Command add_convert(CommandLine& program) {
  Parser parser = program.add_command(
      "convert",
      "Write a reduced body in another format (MBDyn's .fem, SID, HDF5), or a robot in URDF as a model file");
  const auto a = std::make_shared<ConvertArguments>();
  parser.add_option("input", a->input, "Reduced body: .h5, .fem or .sid; robot: .urdf")
      .required()
      .type_name("FILE");
  parser.add_option("--to", a->to, "Format to write; of a robot yaml").choice({"sid", "fem", "h5", "yaml"});
  parser.add_flag("--floating", a->floating,
                  "The robot's root moves freely instead of being fixed to the ground");
  parser.add_flag(
      "--keep-fixed", a->keep_fixed,
      "Keep links on fixed joints as bodies instead of merging them with the links that carry them");
  parser.add_flag("--repair", a->repair,
                  "Replace impossible masses and inertias of the robot by the nearest possible ones, and "
                  "read faulty entries as they are probably meant; each change is listed");
  parser.add_option("--package", a->packages, "Folder of package://NAME, where meshes are")
      .type_name("NAME=FOLDER")
      .repeated();
  parser.add_flag("--no-stress", a->no_stress,
                  "Leave stress out: in SID every point with stress is a node more");
  parser.add_option("-o,--output", a->output, "File to write; default: the input's name with the new ending")
      .type_name("FILE");
  parser.add_flag("--json", a->json, "The file's name as JSON");
  parser.footer(
      "Prints the file's name. docs/reduced-body-format.md lists what each format omits.\nExample:\n  mimbre "
      "convert arm.h5 --to fem\n  mimbre convert robot.urdf -o robot.yaml && mimbre check robot.yaml");
  return {parser, [a] { return run_convert(*a); }};
}

}  // namespace mimbre::app
