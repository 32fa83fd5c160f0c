#pragma once
#include <array>
#include <span>
#include <string_view>

#include "mimbre/spec.h"

/// The description of a kind of surface: all but the distance from it. Each is one file of
/// src/forces/surfaces, which owns both; forces/surfaces/table.h lists them.
namespace mimbre {

struct BodyDrawing;
struct TriangleMesh;
namespace checks {
class CheckedItem;
}

struct SurfaceInfo {
  std::string_view name;  ///< in spec::Surface::kind and in the model file
  /// Keys of the numbers in `size`, m; "size" alone: three numbers.
  std::array<std::string_view, 2> sizes = {};
  bool grid = false, triangles = false;  ///< it has heights; vertices and triangles
  bool one_sided = false;                ///< its inside is below: mirrored along z it is turned over
  bool ball = false;                     ///< the same from all sides

  /// Faults of its heights or triangles.
  void (*check)(const spec::Surface&, const checks::CheckedItem&) = nullptr;
  /// Triangles that it is compiled to.
  TriangleMesh (*mesh)(const spec::Surface&) = nullptr;
  /// Adds it to the drawing of its body, at a pose there; `width`, m: of what has no end.
  void (*draw)(const spec::Surface&, const spec::Pose&, double width, BodyDrawing&);
};

/// All of them, in the order of SurfaceData::kind.
std::span<const SurfaceInfo* const> all_surfaces();
const SurfaceInfo& surface_info(int kind);
/// -1: there is none of that name.
int find_surface(std::string_view name);

}  // namespace mimbre
