#include "urdf/mesh_paths.h"

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <vector>

namespace mimbre::urdf {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code status;
  return fs::is_regular_file(path, status);
}

/// What stands behind `start`, or nothing where the text does not begin so.
std::optional<std::string> behind(const std::string& text, const std::string& start) {
  if (!text.starts_with(start)) return {};
  return text.substr(start.size());
}

}  // namespace

std::optional<std::string> find_mesh(const std::string& written, const std::string& urdf,
                                     const std::map<std::string, std::string>& packages) {
  std::error_code unknown;
  const fs::path folder = fs::absolute(urdf, unknown).lexically_normal().parent_path();
  if (const auto path = behind(written, "file://"))
    return is_file(*path) ? std::optional(*path) : std::nullopt;
  auto in_package = behind(written, "package://");
  if (!in_package) in_package = behind(written, "model://");
  if (!in_package) {
    const fs::path path = (folder / written).lexically_normal();
    return is_file(path) ? std::optional(path.string()) : std::nullopt;
  }
  const auto slash = in_package->find('/');
  if (slash == std::string::npos) return {};
  const std::string package = in_package->substr(0, slash), rest = in_package->substr(slash + 1);
  std::vector<fs::path> places;
  if (const auto given = packages.find(package); given != packages.end()) {
    places.push_back(given->second);
  } else {
    if (const char* const ros = std::getenv("ROS_PACKAGE_PATH")) {
      std::istringstream folders(ros);
      for (std::string one; std::getline(folders, one, ':');) {
        places.push_back(fs::path(one) / package);
        if (fs::path(one).filename() == package) places.emplace_back(one);
      }
    }
    for (fs::path above = folder;; above = above.parent_path()) {
      places.push_back(above / package);
      if (above.filename() == package) places.push_back(above);
      if (above == above.root_path()) break;
    }
  }
  for (const fs::path& place : places)
    if (const fs::path path = (place / rest).lexically_normal(); is_file(path))
      return fs::absolute(path, unknown).string();
  return {};
}

}  // namespace mimbre::urdf
