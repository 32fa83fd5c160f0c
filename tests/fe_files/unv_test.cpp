#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "fe_files/fe_files.h"
#include "fe_files/mesh_formats.h"

/// Universal files, against what Gmsh writes of the same meshes as .msh, and by hand.
namespace mimbre::fe::unv_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string folder = MIMBRE_SOURCE_DIR "/tests/data/unv/";

ImportedMesh parse(const std::string& text) {
  return unv_format.parse(std::make_unique<TextFile>(text, "mesh.unv"), "");
}

std::string refusal(const std::string& text) {
  try {
    parse(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

/// Labels of the nodes of all elements of a group, in our order; as a set, since files may sort elements.
std::multiset<std::vector<std::int64_t>> elements_of(const SolidMesh& mesh, const ElementGroup& group) {
  std::multiset<std::vector<std::int64_t>> all;
  const auto n = static_cast<std::size_t>(node_count(group.type));
  for (std::size_t first = 0; first < group.nodes.size(); first += n) {
    std::vector<std::int64_t> labels;
    for (std::size_t k = 0; k < n; ++k)
      labels.push_back(mesh.labels[static_cast<std::size_t>(group.nodes[first + k])]);
    all.insert(labels);
  }
  return all;
}

const ElementGroup* group_of(const SolidMesh& mesh, const std::string& name) {
  for (const ElementGroup& group : mesh.groups)
    if (group.name == name) return &group;
  return nullptr;
}

std::set<std::int64_t> labels_of(const SolidMesh& mesh, const std::string& set) {
  std::set<std::int64_t> labels;
  for (const NodeSet& one : mesh.node_sets)
    if (one.name == set)
      for (const int node : one.nodes) labels.insert(mesh.labels[static_cast<std::size_t>(node)]);
  return labels;
}

/// Elements of all kinds that Gmsh writes have the same nodes in the same order, groups the same members.
TEST(Unv, IsTheMeshThatGmshWritesAsItsOwn) {
  for (const char* name : {"tet4", "tet10", "hex8", "hex20", "wedge6", "wedge15", "quad4", "quad8"}) {
    SCOPED_TRACE(name);
    const SolidMesh unv = read_mesh(folder + name + ".unv").mesh,
                    msh = read_mesh(folder + name + ".msh").mesh;
    ASSERT_EQ(unv.nodes.cols(), msh.nodes.cols());
    std::map<std::int64_t, Eigen::Vector3d> places;
    for (Eigen::Index k = 0; k < msh.nodes.cols(); ++k)
      places[msh.labels[static_cast<std::size_t>(k)]] = msh.nodes.col(k);
    for (Eigen::Index k = 0; k < unv.nodes.cols(); ++k)
      EXPECT_LE((unv.nodes.col(k) - places.at(unv.labels[static_cast<std::size_t>(k)])).norm(), 1e-15);
    ASSERT_EQ(unv.groups.size(), msh.groups.size());
    for (const ElementGroup& group : msh.groups) {
      const ElementGroup* const same = group_of(unv, group.name);
      ASSERT_TRUE(same) << group.name;
      EXPECT_EQ(same->type, group.type);
      EXPECT_EQ(elements_of(unv, *same), elements_of(msh, group));
    }
    for (const NodeSet& set : msh.node_sets) EXPECT_EQ(labels_of(unv, set.name), labels_of(msh, set.name));
    EXPECT_GE(msh.node_sets.size(), 2u);
  }
}

/// A bar of two bricks: its frequencies do not depend on the file that it comes from.
TEST(Unv, MakesTheSameMatrices) {
  FeCompanions companions;
  companions.materials = {{"", {2.1e11, 0.3, 7850}}};
  const FeModel unv = read_model(folder + "hex20.unv", companions),
                msh = read_model(folder + "hex20.msh", companions);
  ASSERT_EQ(unv.matrices.dofs.size(), msh.matrices.dofs.size());
  // All of it moves along all three axes.
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(unv.matrices.mass.rows());
  const double mass = one.dot(unv.matrices.mass.selfadjointView<Eigen::Lower>() * one),
               wanted = 3 * 7850 * 0.2 * 0.1 * 0.08;
  EXPECT_NEAR(mass, wanted, 1e-9 * wanted);
  EXPECT_NEAR(unv.matrices.stiffness.diagonal().sum(), msh.matrices.stiffness.diagonal().sum(),
              1e-12 * msh.matrices.stiffness.diagonal().sum());
}

const std::string two_tetrahedra = R"(    -1
   164
         1  SI: Meter (newton)         2
    1.0000000000000000D+3    1.0000000000000000D+0    1.0000000000000000D+0
    2.7314999999999998D+2
    -1
    -1
  781
         1         0         0         1
   0.0000000000000000D+00   0.0000000000000000D+00   0.0000000000000000D+00
         2         0         0         1
   1.0000000000000000D+00   0.0000000000000000D+00   0.0000000000000000D+00
         3         0         0         1
   0.0000000000000000D+00   1.0000000000000000D+00   0.0000000000000000D+00
         4         0         0         1
   0.0000000000000000D+00   0.0000000000000000D+00   1.0000000000000000D+00
    -1
    -1
    15
        50         0         0         1  1.00000E+00  1.00000E+00 -1.00000E+00
    -1
    -1
  2412
         7        21         2         1         7         2
         0         1         1
         1         2
         1       111         2         1         7         4
         1         2         3         4
         2       111         3         1         7         4
         2         3         1        50
    -1
    -1
  2467
         1         0         0         0         0         0         0         3
ends
         7         4         0         0         7        50         0         0
         8         7         0         0
         5         0         0         0         0         0         0         1

         8         2         0         0
    -1
    -1
  9999
  whatever there is
    -1
)";

TEST(Unv, ReadsOtherDataSets) {
  const ImportedMesh read = parse(two_tetrahedra);
  EXPECT_THAT(read.mesh.labels, ElementsAre(1, 2, 3, 4, 50));
  EXPECT_EQ(read.mesh.nodes.col(4), Eigen::Vector3d(1, 1, -1));
  // Of the property, where no group lists it; of the group, which has no name, by its number.
  ASSERT_EQ(read.mesh.groups.size(), 2u);
  EXPECT_EQ(read.mesh.groups[0].name, "2");
  EXPECT_THAT(read.mesh.groups[0].nodes, ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(read.mesh.groups[1].name, "5");
  EXPECT_EQ(labels_of(read.mesh, "ends"), (std::set<std::int64_t>{1, 2, 4, 50}));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_THAT(read.warnings[0].message, HasSubstr("in units of 0.001 m"));
}

TEST(Unv, SaysWhatIsWrong) {
  const std::string good = two_tetrahedra;
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return refusal(text);
  };
  EXPECT_EQ(refusal(good), "accepted");
  EXPECT_THAT(refusal("$MeshFormat\n"), HasSubstr("is no universal file"));
  EXPECT_THAT(refusal("    -1\n  2411\n"), HasSubstr("mesh.unv:2:1: ends within a data set"));
  EXPECT_THAT(with("        50         0         0         1", "         4         0         0         1"),
              HasSubstr("node 4 is there already"));
  EXPECT_THAT(with("2       111         3", "2       118         3"),
              HasSubstr("element 2 has 4 nodes; a tetrahedron of the kind 118 has 10"));
  EXPECT_THAT(with("2       111         3", "2       302         3"),
              HasSubstr("of the kind 302, which is not read"));
  EXPECT_THAT(with("         2         3         1        50", "         2         3         1        51"),
              HasSubstr("node 51 of element 2 is not there"));
  EXPECT_THAT(with("         8         2         0         0", "         8         9         0         0"),
              HasSubstr("element 9 of group 5 is not there"));
  EXPECT_THAT(with("    15\n", "    16\n"), HasSubstr("node 50"));
}

TEST(MeshFormats, AreListedByTheirEndings) {
  const std::string help = mesh_formats_help();
  for (const MeshFormat* format : mesh_formats) {
    EXPECT_THAT(help, HasSubstr("  " + std::string(format->ending) + "  "));
    EXPECT_EQ(find_mesh_format("Part" + std::string(format->ending)), format);
  }
  EXPECT_EQ(find_mesh_format("part.step"), nullptr);
  EXPECT_THAT(
      [] { read_mesh("part.step"); },
      testing::ThrowsMessage<InputError>(HasSubstr(".msh (Gmsh) or .inp (CalculiX, Abaqus) or .unv")));
}

}  // namespace
}  // namespace mimbre::fe::unv_test
