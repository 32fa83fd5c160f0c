#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "fe_files/inp/inp_model.h"

/// *TIE of surfaces whose nodes do not meet.
namespace mimbre::fe::inp_tie_test {
namespace {

using Eigen::Vector3d;

struct Solid {
  const char* name;
  std::vector<Vector3d> corners;
  std::vector<std::array<int, 2>> edges;  ///< in the order of the nodes amid them (Abaqus); none: linear
  struct Face {
    std::vector<int> corners;
  };
  std::vector<Face> faces;
};

std::vector<Solid> solids() {
  const std::vector<Vector3d> cube{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                   {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const std::vector<Vector3d> wedge{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  const std::vector<Vector3d> tet{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<std::array<int, 2>> cube_edges{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                                   {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}},
      wedge_edges{{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}},
      tet_edges{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  const std::vector<Solid::Face> cube_faces{{{0, 1, 2, 3}}, {{4, 5, 6, 7}}, {{0, 1, 5, 4}},
                                            {{1, 2, 6, 5}}, {{2, 3, 7, 6}}, {{3, 0, 4, 7}}},
      wedge_faces{{{0, 1, 2}}, {{3, 4, 5}}, {{0, 1, 4, 3}}, {{1, 2, 5, 4}}, {{2, 0, 3, 5}}},
      tet_faces{{{0, 1, 2}}, {{0, 1, 3}}, {{1, 2, 3}}, {{2, 0, 3}}};
  return {{"C3D8", cube, {}, cube_faces},   {"C3D20R", cube, cube_edges, cube_faces},
          {"C3D6", wedge, {}, wedge_faces}, {"C3D15", wedge, wedge_edges, wedge_faces},
          {"C3D4", tet, {}, tet_faces},     {"C3D10", tet, tet_edges, tet_faces}};
}

/// Displacements that a face with nodes amid its sides has exactly, and (without them) its corners.
Vector3d field(const Vector3d& x, bool quadratic) {
  const Vector3d linear(0.3 + 0.2 * x.x() - 0.7 * x.y() + 0.5 * x.z(),
                        -0.1 + 0.9 * x.x() + 0.4 * x.y() - 0.3 * x.z(), 0.6 * x.x() - 0.2 * x.y() + x.z());
  if (!quadratic) return linear;
  return linear + Vector3d(x.x() * x.x() + 0.4 * x.x() * x.y(), x.y() * x.z() - 0.5 * x.z() * x.z(),
                           0.7 * x.y() * x.y() + 0.3 * x.x() * x.z());
}

/// A slave node anywhere on any face moves as the face does there.
TEST(InpTie, SlavesMoveAsEveryFaceOfEverySolid) {
  for (const Solid& solid : solids())
    for (std::size_t face = 0; face < solid.faces.size(); ++face) {
      std::vector<Vector3d> nodes = solid.corners;
      for (const auto& [a, b] : solid.edges)
        nodes.push_back(
            (solid.corners[static_cast<std::size_t>(a)] + solid.corners[static_cast<std::size_t>(b)]) / 2);
      // Corners and places between them, in a tetrahedron far from the solid's.
      const std::size_t own = nodes.size();
      const auto corner = [&](std::size_t k) {
        return solid.corners[static_cast<std::size_t>(solid.faces[face].corners[k])];
      };
      for (const auto& [u, v] : {std::array{0.2, 0.3}, {0.5, 0.1}, {0.05, 0.8}, {0.31, 0.62}}) {
        const std::size_t last = solid.faces[face].corners.size() - 1;
        nodes.push_back(corner(0) + u * (corner(1) - corner(0)) + v * (corner(last) - corner(0)));
      }
      std::string text = "*NODE\n";
      for (std::size_t k = 0; k < nodes.size(); ++k)
        text +=
            fmt::format("{}, {:.17g}, {:.17g}, {:.17g}\n", k + 1, nodes[k].x(), nodes[k].y(), nodes[k].z());
      text += fmt::format("*ELEMENT, TYPE={}, ELSET=E\n1", solid.name);
      for (std::size_t k = 0; k < own; ++k) text += fmt::format(",{}{}", k == 14 ? "\n" : " ", k + 1);
      text += fmt::format("\n*NSET, NSET=N\n{}, {}, {}, {}\n", own + 1, own + 2, own + 3, own + 4);
      text += fmt::format("*SURFACE, NAME=M\n1, S{}\n*SURFACE, NAME=S, TYPE=NODE\nN\n", face + 1);
      text += "*TIE, NAME=T, POSITION TOLERANCE=1e-6\nS, M\n";
      const SolidMesh mesh = parse_inp(std::make_unique<TextFile>(text, "body.inp"), "", false).mesh;
      ASSERT_EQ(mesh.equations.size(), 12u) << solid.name << " S" << face + 1;
      for (const Equation& equation : mesh.equations) {
        double sum = 0;
        for (const LinearTerm& term : equation.terms)
          sum += term.factor * field(mesh.nodes.col(term.node), !solid.edges.empty())[term.direction];
        EXPECT_NEAR(sum, 0, 1e-12) << solid.name << " S" << face + 1;
      }
    }
}

}  // namespace
}  // namespace mimbre::fe::inp_tie_test
