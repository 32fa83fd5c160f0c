#pragma once
#include <map>
#include <string>
#include <vector>

#include "mimbre/diagnostics.h"

namespace mimbre {

struct UrdfOptions {
  bool floating = false;    ///< the root link moves freely; else the ground holds it
  bool keep_fixed = false;  ///< links on fixed joints stay bodies; else they become part of what carries them
  std::map<std::string, std::string> packages;  ///< the folders that package://NAME means, by NAME
  std::string folder;   ///< from which the model names files of meshes; empty: as absolute paths
  bool repair = false;  ///< what cannot be as it is written is made possible, and listed
};

/// A robot as a model file.
struct ConvertedRobot {
  std::string text;                 ///< YAML
  std::vector<Diagnostic> notes;    ///< parts left out or assumed
  std::vector<Diagnostic> repairs;  ///< what was, and what is
};

/// The model file of a robot in URDF (the Unified Robot Description Format of ROS). The assembled position is
/// that in which all coordinates are 0; a body's frame is its link's, and coordinates of joints are URDF's.
/// Limits become stops, damping a damper in the joint, friction dry friction; what is seen of the links
/// becomes shapes. Packages that `options` does not name are sought beside the file and above it. Masses and
/// inertias that no matter can have are repaired if `options` ask for it; else they are noted, and the model
/// is refused. Throws InputError where the file cannot be read, is no URDF, or its links are no tree.
ConvertedRobot convert_urdf(const std::string& path, const UrdfOptions& options = {});

/// Writes the model file; an older one stands until the new one is whole. Throws std::runtime_error.
void save(const ConvertedRobot& robot, const std::string& path);

}  // namespace mimbre
