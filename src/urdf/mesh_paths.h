#pragma once
#include <map>
#include <optional>
#include <string>

namespace mimbre::urdf {

/// Where the file of a mesh is: `written` is package://NAME/path, model://…, file:///path, or a path from the
/// folder of the URDF. Packages are those of `packages`, of the folders in ROS_PACKAGE_PATH, and folders of
/// that name beside the URDF or above it. Nothing where there is no such file.
std::optional<std::string> find_mesh(const std::string& written, const std::string& urdf,
                                     const std::map<std::string, std::string>& packages);

}  // namespace mimbre::urdf
