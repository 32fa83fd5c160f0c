#pragma once
#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "mimbre/diagnostics.h"

namespace mimbre {

/// A surface of triangles, as drawing programs write it.
struct SurfaceMesh {
  Eigen::Matrix3Xd vertices;                  ///< in the file's axes and units; no two alike
  std::vector<std::array<int, 3>> triangles;  ///< of vertices; counterclockwise seen from outside
};

/// Endings of the names of files that read_surface_mesh() reads.
const std::vector<std::string>& surface_mesh_endings();

/// Reads all triangles of a file: STL (binary or text), OBJ, glTF (.gltf, .glb), PLY, Collada (.dae).
/// Polygons are cut into triangles, the parts of a scene are placed as specified there, vertices in the same
/// place become one, triangles without area are left out. Colours, normals and textures are not read.
/// Coordinates are taken as they are written: only Collada specifies a unit, which is turned into metres.
/// Throws InputError, with the file's name, where there is no such file, the format is not known, the file is
/// damaged, a coordinate is not finite or nothing has an area.
SurfaceMesh read_surface_mesh(const std::string& path);

/// Why the surface does not enclose a body; empty where it does: each edge belongs to two triangles, which
/// run along it in opposite directions, and the volume is positive (the triangles face outwards).
std::string why_not_closed(const SurfaceMesh& mesh);

/// ∫ dV within a closed surface, by the divergence theorem: Σ p·(q×r)/6 over the triangles, about the mean of
/// the vertices, so that distance from the origin costs no digits. Negative where the triangles face inwards.
double enclosed_volume(const SurfaceMesh& mesh);

}  // namespace mimbre
