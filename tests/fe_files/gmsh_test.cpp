#include "fe_files/gmsh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "fe/elements/solid_shape.h"
#include "fe_files/element_faces.h"
#include "fe_files/fe_files.h"

namespace mimbre::fe::gmsh_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

ImportedMesh parse(const std::string& text) {
  TextFile file(text, "mesh.msh");
  return parse_gmsh(file);
}

const NodeSet& set_named(const SolidMesh& mesh, const std::string& name) {
  for (const NodeSet& set : mesh.node_sets)
    if (set.name == name) return set;
  throw std::out_of_range(name);
}

/// Volume of a straight-sided element from its corners: tetrahedra, or hexahedra and prisms cut into them.
double volume(const SolidMesh& mesh, const ElementGroup& group) {
  const auto tets = [&]() -> std::vector<std::array<int, 4>> {
    switch (group.type) {
      case ElementType::tet4:
      case ElementType::tet10:
        return {{0, 1, 2, 3}};
      case ElementType::wedge6:
      case ElementType::wedge15:
        return {{0, 1, 2, 3}, {1, 2, 3, 4}, {2, 3, 4, 5}};
      default:
        return {{0, 1, 3, 4}, {1, 2, 3, 6}, {1, 3, 4, 6}, {1, 4, 5, 6}, {3, 4, 6, 7}};
    }
  }();
  double sum = 0;
  const int n = node_count(group.type);
  for (int e = 0; e < group.size(); ++e)
    for (const auto& tet : tets) {
      const auto node = [&](int i) {
        return mesh.nodes.col(
            group.nodes[static_cast<std::size_t>(e * n + tet[static_cast<std::size_t>(i)])]);
      };
      const Eigen::Vector3d a = node(1) - node(0), b = node(2) - node(0), c = node(3) - node(0);
      sum += std::abs(a.cross(b).dot(c)) / 6;
    }
  return sum;
}

/// The nodes beyond the corners stand amid the edges that Abaqus' numbering says.
void expect_midside_nodes(const SolidMesh& mesh, const ElementGroup& group) {
  using Edges = std::vector<std::array<int, 2>>;
  const Edges tet = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  const Edges hex = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                     {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  const Edges wedge = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}};
  const Edges& edges = group.type == ElementType::tet10   ? tet
                       : group.type == ElementType::hex20 ? hex
                                                          : wedge;
  const int n = node_count(group.type), corners = n - static_cast<int>(edges.size());
  for (int e = 0; e < group.size(); ++e)
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const auto node = [&](int i) -> Eigen::Vector3d {
        return mesh.nodes.col(group.nodes[static_cast<std::size_t>(e * n + i)]);
      };
      const Eigen::Vector3d amid = 0.5 * (node(edges[k][0]) + node(edges[k][1]));
      EXPECT_LT((node(corners + static_cast<int>(k)) - amid).norm(), 1e-12)
          << "element " << e << ", edge " << k;
    }
}

TEST(Gmsh, ReadsBothVersionsOfTheSameMesh) {
  const ImportedMesh a = read_gmsh(data_file("gmsh/block-22.msh"));
  const ImportedMesh b = read_gmsh(data_file("gmsh/block-41.msh"));
  for (const ImportedMesh* mesh : {&a, &b}) {
    ASSERT_EQ(mesh->mesh.groups.size(), 1u);
    EXPECT_EQ(mesh->mesh.groups[0].name, "steel");
    EXPECT_EQ(mesh->mesh.groups[0].type, ElementType::tet10);
    EXPECT_NEAR(volume(mesh->mesh, mesh->mesh.groups[0]), 0.2 * 0.1 * 0.1, 1e-15);
    expect_midside_nodes(mesh->mesh, mesh->mesh.groups[0]);
    EXPECT_THAT(mesh->warnings, testing::IsEmpty());
  }
  EXPECT_EQ(a.mesh.labels, b.mesh.labels);
  EXPECT_EQ(a.mesh.nodes, b.mesh.nodes);
  EXPECT_EQ(a.mesh.groups[0].nodes, b.mesh.groups[0].nodes);
}

TEST(Gmsh, MakesNodeSetsOfPhysicalGroups) {
  for (const char* name : {"gmsh/block-22.msh", "gmsh/block-41.msh"}) {
    const SolidMesh mesh = read_gmsh(data_file(name)).mesh;
    for (const auto& [set, x] : {std::pair("left", 0.0), std::pair("right", 0.2)}) {
      std::vector<int> there;
      for (int i = 0; i < mesh.nodes.cols(); ++i)
        if (std::abs(mesh.nodes(0, i) - x) < 1e-12) there.push_back(i);
      EXPECT_EQ(set_named(mesh, set).nodes, there) << name;
    }
    EXPECT_EQ(set_named(mesh, "ends").nodes.size(),
              set_named(mesh, "left").nodes.size() + set_named(mesh, "right").nodes.size());
    EXPECT_EQ(set_named(mesh, "corner").nodes.size(), 1u);
    EXPECT_EQ(set_named(mesh, "steel").nodes.size(), static_cast<std::size_t>(mesh.nodes.cols()));
  }
}

TEST(Gmsh, AgreesWithTheInputFileThatGmshWritesForAbaqus) {
  const SolidMesh a = read_gmsh(data_file("gmsh/block-22.msh")).mesh;
  const ImportedMesh b = read_inp(data_file("gmsh/block.inp"));
  ASSERT_EQ(b.mesh.groups.size(), 1u);
  EXPECT_EQ(a.groups[0].nodes, b.mesh.groups[0].nodes);
  EXPECT_EQ(a.labels, b.mesh.labels);
  EXPECT_LT((a.nodes - b.mesh.nodes).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(set_named(a, "left").nodes, set_named(b.mesh, "left").nodes);
  EXPECT_EQ(set_named(a, "ends").nodes, set_named(b.mesh, "ends").nodes);
}

TEST(Gmsh, ReordersTheNodesOfBricksAndPrisms) {
  const SolidMesh hex = read_gmsh(data_file("gmsh/hex20.msh")).mesh;
  ASSERT_EQ(hex.groups.size(), 1u);
  EXPECT_EQ(hex.groups[0].type, ElementType::hex20);
  EXPECT_NEAR(volume(hex, hex.groups[0]), 2, 1e-12);
  expect_midside_nodes(hex, hex.groups[0]);
  const SolidMesh wedge = read_gmsh(data_file("gmsh/wedge15.msh")).mesh;
  ASSERT_EQ(wedge.groups.size(), 1u);
  EXPECT_EQ(wedge.groups[0].type, ElementType::wedge15);
  EXPECT_NEAR(volume(wedge, wedge.groups[0]), 0.5, 1e-12);
  expect_midside_nodes(wedge, wedge.groups[0]);
}

TEST(Gmsh, MakesShellsOfSurfacesWhereThereAreNoVolumes) {
  const SolidMesh mesh = read_gmsh(data_file("gmsh/plate.msh")).mesh;
  ASSERT_EQ(mesh.groups.size(), 1u);
  EXPECT_EQ(mesh.groups[0].type, ElementType::tri3);
  EXPECT_EQ(mesh.groups[0].name, "plate");
  for (const int node : set_named(mesh, "edge").nodes) EXPECT_EQ(mesh.nodes(0, node), 0);
}

/// A quadrangle of 2 × 1 m and a triangle beside it, with nodes amid their sides.
TEST(Gmsh, MakesCurvedShellsOfQuadraticSurfaces) {
  Folder folder;
  const std::string path = folder.write(
      "plate.msh",
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n11\n1 0 0 0\n2 2 0 0\n3 2 1 0\n4 0 1 0\n5 1 0 0\n"
      "6 2 0.5 0\n7 1 1 0\n8 0 0.5 0\n9 3 0 0\n10 2.5 0 0\n11 2.5 0.5 0\n$EndNodes\n$Elements\n2\n"
      "1 16 2 7 1 1 2 3 4 5 6 7 8\n2 9 2 7 1 2 9 3 10 11 6\n$EndElements\n");
  const SolidMesh mesh = read_gmsh(path).mesh;
  ASSERT_EQ(mesh.groups.size(), 2u);
  for (const ElementGroup& group : mesh.groups) {
    const int corners = node_count(group.type) / 2;
    EXPECT_EQ(group.type, corners == 3 ? ElementType::tri6 : ElementType::quad8);
    for (int k = 0; k < corners; ++k) {
      const auto at = [&](int place) {
        return Eigen::Vector3d(mesh.nodes.col(group.nodes[static_cast<std::size_t>(place)]));
      };
      EXPECT_LT((at(corners + k) - (at(k) + at((k + 1) % corners)) / 2).norm(), 1e-15);
    }
  }
  FeCompanions companions;
  companions.materials = {{"", {2.1e11, 0.3, 7850}}};
  const auto refusal = [&] {
    try {
      read_model(path, companions);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal(), HasSubstr("--thickness [GROUP=]T"));
  companions.thicknesses = {{"", 0.01}};
  companions.materials[0].material.density = 0;
  EXPECT_THAT(refusal(), HasSubstr("--density [MATERIAL=]RHO"));
  companions.materials[0].material.density = 7850;
  const FeModel model = read_model(path, companions);
  const Eigen::MatrixXd R = [&] {
    Eigen::MatrixXd along = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(model.matrices.dofs.size()), 1);
    for (std::size_t r = 0; r < model.matrices.dofs.size(); ++r)
      if (model.matrices.dofs[r].direction == 2) along(static_cast<Eigen::Index>(r), 0) = 1;
    return along;
  }();
  const Eigen::SparseMatrix<double> mass = model.matrices.mass.selfadjointView<Eigen::Lower>();
  EXPECT_NEAR((R.transpose() * mass * R)(0, 0), 7850 * 0.01 * 2.5, 1e-9);
}

TEST(Gmsh, ScalesToMetres) {
  const SolidMesh m = read_gmsh(data_file("gmsh/block-41.msh")).mesh;
  const SolidMesh mm = read_gmsh(data_file("gmsh/block-41.msh"), {1e-3, 1e3, 1}).mesh;
  EXPECT_LT((m.nodes * 1e-3 - mm.nodes).norm(), 1e-18);
}

const std::string kHead = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const std::string kTetNodes = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n";

TEST(Gmsh, AnElementInTwoGroupsWeighsOnce) {
  const SolidMesh mesh =
      parse(kHead + kTetNodes + "$Elements\n2\n1 4 2 1 1 1 2 3 4\n2 4 2 2 1 1 2 3 4\n$EndElements\n").mesh;
  ASSERT_EQ(mesh.groups.size(), 1u);
  EXPECT_EQ(mesh.groups[0].size(), 1);
  EXPECT_THAT(set_named(mesh, "1").nodes, ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(set_named(mesh, "2").nodes, ElementsAre(0, 1, 2, 3));
}

TEST(Gmsh, TakesWindowsLineEnds) {
  std::string text = kHead + kTetNodes + "$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n";
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2)
    text.replace(at, 1, "\r\n");
  EXPECT_EQ(parse(text).mesh.nodes.cols(), 4);
}

TEST(Gmsh, ReadsPyramids) {
  // Nodes amid the edges 01, 03, 04, 12, 14, 23, 24, 34, as Gmsh has them.
  const std::string nodes =
      "$Nodes\n13\n1 -1 -1 0\n2 1 -1 0\n3 1 1 0\n4 -1 1 0\n5 0 0 1\n6 0 -1 0\n7 -1 0 0\n8 -.5 -.5 .5\n9 1 0 "
      "0\n"
      "10 .5 -.5 .5\n11 0 1 0\n12 .5 .5 .5\n13 -.5 .5 .5\n$EndNodes\n";
  const SolidMesh linear = parse(kHead + nodes + "$Elements\n1\n1 7 2 1 1 1 2 3 4 5\n$EndElements\n").mesh;
  EXPECT_EQ(linear.groups.at(0).type, ElementType::pyramid5);
  EXPECT_THAT(linear.groups[0].nodes, ElementsAre(0, 1, 2, 3, 4));
  const SolidMesh quadratic =
      parse(kHead + nodes + "$Elements\n1\n1 19 2 1 1 1 2 3 4 5 6 7 8 9 10 11 12 13\n$EndElements\n").mesh;
  ASSERT_EQ(quadratic.groups.at(0).type, ElementType::pyramid13);
  const NodePositions wanted = reference_nodes(ElementType::pyramid13);
  for (Eigen::Index k = 0; k < 13; ++k)
    EXPECT_EQ(
        (quadratic.nodes.col(quadratic.groups[0].nodes[static_cast<std::size_t>(k)]) - wanted.col(k)).norm(),
        0);
}

TEST(Gmsh, SaysWhatIsWrong) {
  const auto wrong = [](const std::string& text) { return complaint([&] { parse(text); }); };
  const std::string good = "$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n";
  EXPECT_THAT(complaint([] { read_gmsh("/nowhere/mesh.msh"); }), HasSubstr("cannot be opened"));
  EXPECT_THAT(complaint([] { read_gmsh(data_file("gmsh/block-binary.msh")); }),
              HasSubstr("is binary; save it as text"));
  EXPECT_THAT(wrong(""), HasSubstr("ends within the file's head"));
  EXPECT_THAT(wrong("*NODE\n"), HasSubstr("mesh.msh:1:1: is no Gmsh mesh"));
  EXPECT_THAT(wrong(std::string("$Mesh\0", 6)), HasSubstr("zero bytes"));
  EXPECT_THAT(wrong("$MeshFormat\n4.0 0 8\n$EndMeshFormat\n"),
              HasSubstr("has format 4; 2.2 and 4.1 are read"));
  EXPECT_THAT(wrong(kHead), HasSubstr("ends without $Nodes and $Elements"));
  EXPECT_THAT(wrong(kHead + "$Nodes\n3\n1 0 0 0\n"), HasSubstr("ends within $Nodes"));
  EXPECT_THAT(wrong(kHead + "$Nodes\n99999999999999\n1 0 0 0\n$EndNodes\n"),
              HasSubstr("'$EndNodes' is no node number"));
  EXPECT_THAT(wrong(kHead + "$Nodes\n1\n1 0 0 nan\n$EndNodes\n"),
              HasSubstr("mesh.msh:6:1: 'nan' is no coordinate"));
  EXPECT_THAT(wrong(kHead + "$Nodes\n1\n1 0 0 1e999\n$EndNodes\n"), HasSubstr("'1e999' is no coordinate"));
  EXPECT_THAT(wrong(kHead + "$Nodes\n2\n1 0 0 0\n1 0 0 1\n$EndNodes\n"),
              HasSubstr("node 1 is there already"));
  EXPECT_THAT(wrong(kHead + kTetNodes + "$Elements\n1\n1 4 2 1 1 1 2 3 5\n$EndElements\n"),
              HasSubstr("node 5 of element 1 is not there"));
  EXPECT_THAT(wrong(kHead + kTetNodes +
                    "$Elements\n1\n1 13 2 1 1 1 2 3 4 1 2 3 4 1 2 3 4 1 2 3 4 1 2\n$EndElements\n"),
              HasSubstr("element 1 is a 18-node prism, of which no body can be made"));
  EXPECT_THAT(wrong(kHead + kTetNodes + "$Elements\n1\n1 4 2 1 1 1 2 3\n$EndElements\n"),
              HasSubstr("node of the element is missing"));
  EXPECT_THAT(wrong(kHead + good), HasSubstr("$Nodes must stand before $Elements"));
  EXPECT_THAT(wrong(kHead + kTetNodes + "$Elements\n1\n1 15 2 1 1 1\n$EndElements\n"),
              HasSubstr("neither volume nor surface elements"));
  EXPECT_EQ(wrong(kHead + kTetNodes + good), "");
}

}  // namespace
}  // namespace mimbre::fe::gmsh_test
