#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/output_place.h"
#include "mimbre/inertia_study.h"

namespace mimbre {

spec::Model with_choice(const spec::Model& model, const InertiaStudy& study) {
  spec::Model changed = model;
  for (const InertiaStudy::Body& body : study.bodies)
    changed.bodies[static_cast<std::size_t>(body.index)].neglected = body.neglected;
  return changed;
}

void write_choice(const InertiaStudy& study, const std::string& model_file, const std::string& path,
                  const std::vector<std::string>& settings) {
  namespace fs = std::filesystem;
  const std::string model =
      fs::absolute(model_file).lexically_relative(fs::absolute(path).parent_path()).generic_string();
  std::string text = fmt::format("# By mimbre terms: no output is off by more than {:.2g} % of its range.\n",
                                 100 * study.error);
  if (!settings.empty()) text += fmt::format("# With {}; give these again.\n", fmt::join(settings, ", "));
  text += fmt::format("mimbre: 1\ninclude: [{}]\n", nlohmann::json(model).dump());
  std::string bodies;
  for (const InertiaStudy::Body& body : study.bodies)
    if (!body.neglected.empty())
      bodies += fmt::format("  {}: [{}]\n", body.name, fmt::join(names_of(body.neglected), ", "));
  text += bodies.empty() ? "neglected_inertia: {}\n" : "neglected_inertia:\n" + bodies;
  try {
    write_whole(path, text);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("cannot write '{}': {}", path, error.what()));
  }
}

}  // namespace mimbre
