#pragma once
#include <array>
#include <string_view>

/// The properties of the kinds of surfaces besides where their points are, which is in
/// src/forces/surfaces: the rows are those of spec::Surface::Kind and of the table there.
namespace mimbre {

struct SurfaceKind {
  std::string_view name;
  /// Keys of the numbers in `size`, m; "size" alone: three numbers.
  std::array<std::string_view, 2> sizes = {};
  bool grid = false, triangles = false;  ///< it has heights; vertices and triangles
};

constexpr std::array<SurfaceKind, 7> surface_kinds{{
    {"half_space"},
    {"box", {"size"}},
    {"cylinder", {"radius", "length"}},
    {"capsule", {"radius", "length"}},
    {"sphere", {"radius"}},
    {"heights", {}, true},
    {"mesh", {}, false, true},
}};

}  // namespace mimbre
