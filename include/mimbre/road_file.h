#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

/// Roads of measured or made height, from files of ASAM OpenCRG (.crg).
namespace mimbre {

/// A surface over a curved grid: u along a reference line, v across it, to the left. All in m and rad.
///
/// The height over a place is height(u, v) + line_height(u) + bank(u) v, linear between the grid's points.
struct RoadGrid {
  double start_u = 0, increment = 1;  ///< u of the reference line's points is start_u + i increment
  std::vector<double> x, y;           ///< the reference line's points
  std::vector<double> line_height;    ///< of the same points, from the slope
  std::vector<double> bank;           ///< of the same points: how much it rises to the left, m/m
  std::vector<double> v;              ///< of the long sections, growing from right to left
  std::vector<double> height;  ///< of all points, section by section for the first u, then for the next
  /// How many heights the file did not know. They have the height of the nearest known section of the same u,
  /// or, where there is none, of the nearest u.
  std::size_t gaps = 0;
  std::size_t holes = 0;  ///< those of them that lie between known sections of their u
  /// v of the outermost sections whose height the file knows, of each u; empty where it knows all of them.
  std::vector<double> right, left;
  std::vector<std::string> unused;  ///< what the file asks for that is not done, as "$SECTION KEY"

  std::size_t along() const { return x.size(); }
  std::size_t across() const { return v.size(); }
};

/// Reads a file of the formats LRFI, LDFI, KRFI, KDFI (text) and KRBI, KDBI, LRBI, LDBI (binary, big-endian).
/// Throws InputError where the file is none of these, is damaged, or its parts contradict each other.
RoadGrid read_road_grid(const std::filesystem::path& path);

}  // namespace mimbre
