#pragma once
#include <array>
#include <map>
#include <string>
#include <vector>

#include "math/rotation.h"

/// Topology of triangle meshes: vertices, and for each triangle its corners' indices, counterclockwise from
/// outside.
namespace mimbre {

using Triangle = std::array<int, 3>;

/// Twice the area of a triangle times its normal, m².
Vec3<double> doubled_area(const std::vector<Vec3<double>>& vertices, const Triangle& triangle);

/// Each directed edge (from, to), and the triangle and corner from which it starts.
std::map<std::array<int, 2>, std::array<int, 2>> edges_of(const std::vector<Triangle>& triangles);

/// Why triangles are no closed surface with an inside; empty: they are one.
std::string why_not_closed(const std::vector<Vec3<double>>& vertices, const std::vector<Triangle>& triangles);

}  // namespace mimbre
