#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fe_files/fe_files.h"
#include "fe_files/inp/inp_model.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe::inp_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

ImportedMesh parse(const std::string& text) {
  return parse_inp(std::make_unique<TextFile>(text, "body.inp"), "", false);
}

const std::vector<int>& nodes_of(const SolidMesh& mesh, const std::string& name) {
  for (const NodeSet& set : mesh.node_sets)
    if (set.name == name) return set.nodes;
  throw std::out_of_range(name);
}

const std::string kNodes = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n";
const std::string kBrick = kNodes + "*ELEMENT, TYPE=C3D8, ELSET=brick\n10, 1,2,3,4,5,6,7,8\n";

TEST(Inp, ReadsTheJobThatCalculixRan) {
  const ImportedMesh read = read_inp(data_file("calculix/beam.inp"));
  const SolidMesh& mesh = read.mesh;
  EXPECT_EQ(mesh.nodes.cols(), 12);
  ASSERT_EQ(mesh.groups.size(), 1u);
  EXPECT_EQ(mesh.groups[0].type, ElementType::hex8);
  EXPECT_EQ(mesh.groups[0].name, "Eall");
  EXPECT_EQ(mesh.groups[0].material, 0);
  EXPECT_THAT(mesh.groups[0].labels, ElementsAre(1, 2));
  ASSERT_EQ(mesh.materials.size(), 1u);
  EXPECT_EQ(mesh.materials[0].name, "STEEL");
  EXPECT_EQ(mesh.materials[0].material.young, 210e9);
  EXPECT_EQ(mesh.materials[0].material.poisson, 0.3);
  EXPECT_EQ(mesh.materials[0].material.density, 7800);
  EXPECT_THAT(nodes_of(mesh, "end"), ElementsAre(8, 9, 10, 11));
  EXPECT_THAT(read.warnings, IsEmpty());
}

TEST(Inp, IgnoresCaseBlanksCommentsAndBrokenLines) {
  const SolidMesh mesh =
      parse(
          "** comment\n*node , nset = All\n 1, 0., 0., 0.\n\n2,1,,\n 3, 0, 1.D0\n4, 0,0, 1E+0,\n"
          "*Element, type=c3d4,\n elset=Body\n7, 1, 2,\n 3, 4\n"
          "*NSET, nset=\"two words\"\n1,\n2\n*NSET, NSET=MORE, GENERATE\n2, 4, 2\n"
          "*NSET, NSET=more\n all\n")
          .mesh;
  EXPECT_THAT(mesh.labels, ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(mesh.nodes.col(1), Eigen::Vector3d(1, 0, 0));
  ASSERT_EQ(mesh.groups.size(), 1u);
  EXPECT_EQ(mesh.groups[0].name, "Body");
  EXPECT_THAT(mesh.groups[0].nodes, ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(nodes_of(mesh, "two words"), ElementsAre(0, 1));
  EXPECT_THAT(nodes_of(mesh, "MORE"), ElementsAre(0, 1, 2, 3));
}

TEST(Inp, SectionsMakeGroupsWithMaterials) {
  const ImportedMesh read = parse(
      kNodes +
      "*ELEMENT, TYPE=C3D4, ELSET=all\n1, 1,2,4,5\n2, 2,3,4,7\n*ELEMENT, TYPE=S4R, ELSET=plate\n3, 5,6,7,8\n"
      "*ELSET, ELSET=soft\n2\n*MATERIAL, NAME=steel\n*ELASTIC\n2e11, 0.3\n*DENSITY\n7800\n"
      "*MATERIAL, NAME=rubber\n*DENSITY\n1000\n*ELASTIC, TYPE=ISOTROPIC\n1e6, 0.45\n"
      "*SOLID SECTION, ELSET=all, MATERIAL=Steel\n*SOLID SECTION, ELSET=soft, MATERIAL=rubber\n"
      "*SHELL SECTION, ELSET=plate, MATERIAL=steel\n0.01, 5\n");
  const SolidMesh& mesh = read.mesh;
  ASSERT_EQ(mesh.groups.size(), 3u);
  EXPECT_EQ(mesh.groups[0].name, "all");
  EXPECT_EQ(mesh.groups[0].material, 0);
  EXPECT_EQ(mesh.groups[1].name, "soft");
  EXPECT_EQ(mesh.groups[1].material, 1);
  EXPECT_THAT(mesh.groups[1].labels, ElementsAre(2));
  EXPECT_EQ(mesh.groups[2].type, ElementType::quad4);
  EXPECT_EQ(mesh.groups[2].thickness, 0.01);
  EXPECT_THAT(nodes_of(mesh, "soft"), ElementsAre(1, 2, 3, 6));
  EXPECT_THAT(read.warnings, IsEmpty());
}

TEST(Inp, ScalesMillimetresAndTonnes) {
  Folder folder;
  const std::string path = folder.write(
      "mm.inp",
      kBrick +
          "*MATERIAL, NAME=steel\n*ELASTIC\n210000, 0.3\n*DENSITY\n7.8e-9\n"
          "*ELEMENT, TYPE=S4, ELSET=skin\n11, 1,2,3,4\n*SHELL SECTION, ELSET=skin, MATERIAL=steel\n2\n"
          "*SOLID SECTION, ELSET=brick, MATERIAL=steel\n");
  const SolidMesh mesh = read_inp(path, {1e-3, 1e3, 1}).mesh;
  EXPECT_NEAR(mesh.materials[0].material.young, 210e9, 1);
  EXPECT_NEAR(mesh.materials[0].material.density, 7800, 1e-8);
  EXPECT_NEAR(mesh.nodes.maxCoeff(), 1e-3, 1e-18);
  EXPECT_NEAR(mesh.groups[1].thickness, 2e-3, 1e-15);
}

TEST(Inp, ReadsBeamsWithRectangles) {
  const SolidMesh mesh =
      parse(
          "*NODE\n1,0,0,0\n2,1,0,0\n*ELEMENT, TYPE=B31, ELSET=bar\n1,1,2\n*MATERIAL, NAME=m\n"
          "*ELASTIC\n1e9,0.2\n*DENSITY\n1000\n"
          "*BEAM SECTION, ELSET=bar, MATERIAL=m, SECTION=RECT\n0.1, 0.2\n0, 1, 0\n")
          .mesh;
  ASSERT_EQ(mesh.beams.size(), 1u);
  const BeamElement& beam = mesh.beams[0];
  EXPECT_EQ(beam.y_direction, Eigen::Vector3d::UnitY());
  EXPECT_NEAR(beam.section.area, 0.02, 1e-15);
  // 0.1 along the first axis (y): bending in the x–y plane is about the side 0.2.
  EXPECT_NEAR(beam.section.Iz, 0.2 * 1e-3 / 12, 1e-15);
  EXPECT_NEAR(beam.section.Iy, 0.1 * 8e-3 / 12, 1e-15);
  EXPECT_EQ(beam.material.density, 1000);
}

TEST(Inp, ReadsBeamSectionsByTheirOtherNames) {
  const auto section = [](const std::string& card) {
    return parse(
               "*NODE\n1,0,0,0\n2,1,0,0\n*ELEMENT, TYPE=B31, ELSET=bar\n1,1,2\n*MATERIAL, NAME=m\n"
               "*ELASTIC\n1e9,0.2\n*DENSITY\n1000\n" +
               card + ", ELSET=bar, MATERIAL=m\n0.1, 0.02\n0, 1, 0\n")
        .mesh.beams.at(0)
        .section;
  };
  EXPECT_EQ(section("*BEAM SECTION, SECTION=RECTANGULAR").Iz, section("*BEAM SECTION, SECTION=RECT").Iz);
  EXPECT_EQ(section("*BEAM GENERAL SECTION, SECTION=PIPE").Iz, section("*BEAM SECTION, SECTION=PIPE").Iz);
}

/// The nodes lie on the side of the section where OFFSET = 0.5 puts them, along a bow on its outside.
TEST(Inp, OffsetsMoveTheAxesOfBeams) {
  std::string text = "*NODE\n";
  const double radius = 0.5;
  for (int k = 0; k <= 12; ++k) {
    const double angle = 0.1 * k;
    text += std::to_string(k + 1) + ", " + std::to_string(radius * std::cos(angle)) + ", " +
            std::to_string(radius * std::sin(angle)) + ", 0\n";
  }
  text += "*ELEMENT, TYPE=B31, ELSET=bar\n";
  for (int k = 1; k <= 12; ++k)
    text += std::to_string(k) + ", " + std::to_string(k) + ", " + std::to_string(k + 1) + "\n";
  text +=
      "*MATERIAL, NAME=m\n*ELASTIC\n1e9,0.2\n*DENSITY\n1000\n"
      "*BEAM SECTION, ELSET=bar, MATERIAL=m, SECTION=RECT, OFFSET1=0.5, OFFSET2=-0.25\n0.02, 0.04\n0, 0, 1\n";
  const SolidMesh mesh = parse(text).mesh;
  ASSERT_EQ(mesh.beams.size(), 12u);
  for (std::size_t k = 1; k + 1 < mesh.beams.size(); ++k)
    for (std::size_t end = 0; end < 2; ++end) {
      // 1 is z; 2 = tangent × z points outwards.
      const Eigen::Vector3d node = mesh.nodes.col(mesh.beams[k].nodes[end]);
      const Eigen::Vector3d arm = 0.25 * 0.04 * node.normalized() - 0.5 * 0.02 * Eigen::Vector3d::UnitZ();
      EXPECT_LT((mesh.beams[k].offsets[end] - arm).norm(), 1e-5 * arm.norm()) << k;
    }
}

/// Layers from the bottom to the top, about the nodes as OFFSET says.
TEST(Inp, LayersAreSheetsBesideTheNodes) {
  const SolidMesh mesh =
      parse(kNodes +
            "*ELEMENT, TYPE=S4, ELSET=E\n1, 1,2,3,4\n*MATERIAL, NAME=m\n*ELASTIC\n1e9,0.2\n*DENSITY\n1000\n"
            "*MATERIAL, NAME=n\n*ELASTIC\n2e9,0.2\n*DENSITY\n2000\n"
            "*ORIENTATION, NAME=O\n1,0,0,0,1,0\n*ORIENTATION, NAME=P\n0,1,0,-1,0,0\n"
            "*SHELL SECTION, ELSET=E, COMPOSITE, ORIENTATION=O, OFFSET=-0.5\n0.1, 3, m, P\n0.3, , n\n0.2, , "
            "m, O\n")
          .mesh;
  ASSERT_EQ(mesh.groups.size(), 3u);
  // The nodes lie on the bottom.
  const double thickness[] = {0.1, 0.3, 0.2}, middle[] = {0.05, 0.25, 0.5}, density[] = {1000, 2000, 1000};
  const int orientation[] = {1, 0, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    const ElementGroup& group = mesh.groups[k];
    EXPECT_NEAR(group.thickness, thickness[k], 1e-15);
    EXPECT_NEAR(group.offset, middle[k], 1e-15);
    EXPECT_EQ(mesh.materials[static_cast<std::size_t>(group.material)].material.density, density[k]);
    EXPECT_THAT(group.orientations, ElementsAre(orientation[k]));
    EXPECT_EQ(group.nodes, mesh.groups[0].nodes);
  }
}

TEST(Inp, SurfacesBecomeNodeSets) {
  const SolidMesh mesh = parse(kBrick +
                               "*SURFACE, NAME=left, TYPE=ELEMENT\nbrick, S6\n*SURFACE, NAME=top\n10, S2\n"
                               "*SURFACE, TYPE=NODE, NAME=points\n3\n")
                             .mesh;
  for (const int node : nodes_of(mesh, "left")) EXPECT_EQ(mesh.nodes(0, node), 0);
  EXPECT_EQ(nodes_of(mesh, "left").size(), 4u);
  for (const int node : nodes_of(mesh, "top")) EXPECT_EQ(mesh.nodes(2, node), 1);
  EXPECT_THAT(nodes_of(mesh, "points"), ElementsAre(2));
}

TEST(Inp, IncludesFilesBesideIt) {
  Folder folder;
  folder.write("nodes.txt", kNodes);
  folder.write("elements.txt", "10, 1,2,3,4,5,6,7,8\n");
  const std::string path = folder.write(
      "body.inp", "*INCLUDE, INPUT=nodes.txt\n*ELEMENT, TYPE=C3D8, ELSET=b\n*INCLUDE, INPUT=elements.txt\n");
  EXPECT_THAT(complaint([&] { read_inp(path); }), IsEmpty());
  const SolidMesh mesh = read_inp(path).mesh;
  EXPECT_EQ(mesh.nodes.cols(), 8);
  ASSERT_EQ(mesh.groups.size(), 1u);
  EXPECT_THAT(mesh.groups[0].labels, ElementsAre(10));
  folder.write("loop.inp", "*INCLUDE, INPUT=again.inp\n");
  folder.write("again.inp", "*INCLUDE, INPUT=loop.inp\n");
  EXPECT_THAT(complaint([&] { read_inp(folder.path("loop.inp")); }), HasSubstr("'loop.inp' includes itself"));
  folder.write("missing.inp", "*INCLUDE, INPUT=nothing.inp\n");
  EXPECT_THAT(complaint([&] { read_inp(folder.path("missing.inp")); }),
              HasSubstr("is not there to be included"));
}

/// Lines of data may come from another file, and go on behind it.
TEST(Inp, IncludesLinesOfData) {
  Folder folder;
  folder.write("middle.txt", "2,1,0,0\n3,1,1,0\n");
  folder.write("set.txt", "1,\n 2\n");
  const SolidMesh mesh =
      read_inp(folder.write("body.inp",
                            "*NODE, NSET=all\n1,0,0,0\n*Include,\n input=middle.txt\n4,0,0,1\n"
                            "*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n*NSET, NSET=a\n"
                            "*INCLUDE, INPUT=set.txt\n4\n"))
          .mesh;
  EXPECT_THAT(mesh.labels, ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(nodes_of(mesh, "all"), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(nodes_of(mesh, "a"), ElementsAre(0, 1, 3));
  folder.write("two.txt", "9,0,0,z\n");
  EXPECT_THAT(complaint([&] { read_inp(folder.write("bad.inp", "*NODE\n*INCLUDE, INPUT=two.txt\n")); }),
              HasSubstr("two.txt:1:1: 'z' is no coordinate"));
}

TEST(Inp, TakesAByteOrderMark) { EXPECT_EQ(parse("\xef\xbb\xbf" + kBrick).mesh.nodes.cols(), 8); }

TEST(Inp, WarnsOfWhatItLeavesOut) {
  const auto warnings = [](const std::string& text) {
    std::string all;
    for (const Diagnostic& warning : parse(text).warnings) all += to_string(warning) + "\n";
    return all;
  };
  EXPECT_THAT(warnings(kBrick + "*BOUNDARY\n1,1,3\n*BOUNDARY\n2,1,3\n"),
              testing::StrEq("body.inp:12:1: *BOUNDARY is left out\n"));
  EXPECT_THAT(warnings(kBrick + "*ELEMENT, TYPE=DASHPOTA, ELSET=m\n99, 1, 2\n"),
              HasSubstr("elements DASHPOTA are left out"));
  EXPECT_THAT(warnings(kBrick + "*ELEMENT, TYPE=SPRING1, ELSET=m\n99, 1\n"),
              HasSubstr("elements SPRING1 are left out: a spring to the ground would hold the body"));
  EXPECT_THAT(warnings(kBrick + "*NSET, NSET=a\n1,99\n"), HasSubstr("node 99 of the set a is not there"));
  EXPECT_THAT(warnings(kBrick + "*NSET, NSET=a, GENERATE\n1, 9000000000000000000, 1\n"), "");
  EXPECT_THAT(
      warnings(kBrick + "*ELEMENT, TYPE=T3D2, ELSET=bar\n11, 1,2\n*SURFACE, NAME=s\nbar, S1\n77, S1\n"),
      HasSubstr("element 11 of the surface s is not part of the body"));
  EXPECT_THAT(warnings(kBrick + "*SURFACE, NAME=s\n77, S1\n"),
              HasSubstr("element 77 of the surface s is not there"));
  EXPECT_THAT(warnings(kBrick + "*ELEMENT, TYPE=CPS4, ELSET=face\n99, 1,2,3,4\n"),
              HasSubstr("they only make node sets"));
  EXPECT_THAT(warnings(kBrick + "*MATERIAL, NAME=a\n*ELASTIC\n1,0.3\n"),
              HasSubstr("material a has no *DENSITY"));
  EXPECT_EQ(warnings(kBrick + "*STEP\n*BOUNDARY\n1,1,3\n*CLOAD\n1,1,1\n*END STEP\n"), "");
}

/// Hyperelastic, plastic, of fluids or of heat: named with the section that takes it. One that nothing takes
/// does no harm.
TEST(Inp, MaterialsInUseMustBeElastic) {
  Folder folder;
  const std::string other = "*MATERIAL, NAME=rubber\n*HYPERELASTIC\n1,2\n*DENSITY\n1000\n",
                    steel = "*MATERIAL, NAME=steel\n*ELASTIC\n2e11,0.3\n*DENSITY\n7800\n";
  const std::string spare =
      folder.write("a.inp", kBrick + other + steel + "*SOLID SECTION, ELSET=brick, MATERIAL=steel\n");
  EXPECT_EQ(complaint([&] { read_model(spare); }), "");
  const std::string used =
      folder.write("b.inp", kBrick + other + steel + "*SOLID SECTION, ELSET=brick, MATERIAL=rubber\n");
  EXPECT_THAT(complaint([&] { read_model(used); }),
              HasSubstr("b.inp:22:1: material 'rubber' has no *ELASTIC that is read"));
}

TEST(Inp, SaysWhatIsWrong) {
  const auto wrong = [](const std::string& text) { return complaint([&] { parse(text); }); };
  EXPECT_EQ(wrong(kBrick), "");
  EXPECT_THAT(wrong(""), HasSubstr("has no nodes"));
  EXPECT_THAT(wrong("*NODE\n1,0,0,0\n1,0,0,0\n"), HasSubstr("body.inp:3:1: node 1 is there already"));
  EXPECT_THAT(wrong("*NODE\n1,0,0,nan\n"), HasSubstr("'nan' is no coordinate of node 1"));
  EXPECT_THAT(wrong("*NODE\nx,0,0,0\n"), HasSubstr("'x' is no node number"));
  EXPECT_THAT(wrong("*NODE, SYSTEM=C\n1,0,0,0\n"), HasSubstr("cylindrical"));
  EXPECT_THAT(wrong(kNodes + "*ELEMENT, TYPE=C3D8\n1, 1,2,3,4,5,6,7,9\n"),
              HasSubstr("node 9 of element 1 is not there"));
  EXPECT_THAT(wrong(kNodes + "*ELEMENT, TYPE=C3D8\n1, 1,2,3,4,5,6,7\n"),
              HasSubstr("element 1 has 7 of the 8 nodes of C3D8"));
  EXPECT_THAT(wrong(kNodes + "*ELEMENT, TYPE=C3D4\n1, 1,2,3,4,5\n"),
              HasSubstr("more than the 4 nodes of C3D4"));
  EXPECT_THAT(wrong(kBrick + "*ELEMENT, TYPE=C3D8\n10, 1,2,3,4,5,6,7,8\n"),
              HasSubstr("element 10 is there already"));
  for (const char* type : {"S9R", "B33", "C3D27", "C3D20T", "U1"})
    EXPECT_THAT(wrong(kNodes + "*ELEMENT, TYPE=" + type + "\n1,1\n"),
                HasSubstr(std::string("elements ") + type + " are not read; there are C3D4"));
  EXPECT_THAT(wrong(kBrick + "*ELSET, ELSET=a, GENERATE\n1, 9000000000000000000, 1\n"), IsEmpty());
  EXPECT_THAT(wrong(kBrick + "*SOLID SECTION, ELSET=brik, MATERIAL=m\n"),
              HasSubstr("no element set 'brik' (did you mean 'brick'?)"));
  EXPECT_THAT(wrong(kBrick + "*SOLID SECTION, ELSET=brick, MATERIAL=m\n"),
              HasSubstr("body.inp:12:1: there is no material 'm'"));
  EXPECT_THAT(wrong(kBrick + "*MATERIAL, NAME=m\n*SHELL SECTION, ELSET=brick, MATERIAL=m\n1\n"),
              HasSubstr("element 10 of the set brick needs a *SOLID SECTION"));
  EXPECT_THAT(wrong(kBrick + "*ELASTIC\n1,0.3\n"), HasSubstr("*ELASTIC stands before every *MATERIAL"));
  EXPECT_THAT(wrong(kBrick + "*MATERIAL, NAME=m\n*ELASTIC, TYPE=ORTHO\n1,0.3\n"),
              HasSubstr("*ELASTIC needs nine constants"));
  EXPECT_THAT(wrong(kBrick + "*MATERIAL, NAME=m\n*ELASTIC\n1,0.5\n"), HasSubstr("Poisson's ratio 0.5"));
  EXPECT_THAT(wrong(kBrick + "*NGEN\n1,2,1\n"), HasSubstr("write the finished mesh"));
  EXPECT_THAT(wrong("*PART, NAME=a\n*END PART\n*PART, NAME=b\n"), HasSubstr("a second part"));
  // What the body would lack, or have in other directions.
  EXPECT_THAT(wrong(kBrick + "*ELEMENT, TYPE=MASS, ELSET=p\n20, 1\n"), HasSubstr("element 20 has no *MASS"));
  EXPECT_THAT(wrong(kBrick + "*ELEMENT, TYPE=SPRINGA, ELSET=p\n20, 1,7\n"),
              HasSubstr("element 20 has no *SPRING"));
  const std::string material = "*MATERIAL, NAME=m\n*ELASTIC\n1,0.3\n";
  EXPECT_THAT(wrong(kBrick + "*ELEMENT, TYPE=T3D2, ELSET=p\n20, 1,7\n" + material +
                    "*SOLID SECTION, ELSET=p, MATERIAL=m\n1\n"),
              HasSubstr("body.inp:17:1: the set p has a section and holds nothing but trusses"));
  EXPECT_EQ(wrong(kBrick + "*ELEMENT, TYPE=CPS4, ELSET=p\n20, 1,2,3,4\n*ELSET, ELSET=all\nbrick, p\n" +
                  material + "*SOLID SECTION, ELSET=all, MATERIAL=m\n"),
            "");
  EXPECT_THAT(wrong(kBrick + "*MEMBRANE SECTION, ELSET=brick, MATERIAL=m\n1\n"),
              HasSubstr("body.inp:12:1: membranes are not read"));
  const std::string turned = "*NSET, NSET=t\n1\n*TRANSFORM, NSET=t\n0,1,0,-1,0,0\n";
  EXPECT_EQ(wrong(kBrick + turned + "*EQUATION\n2\n2,1,1.,3,1,-1.\n"), "");
  EXPECT_THAT(wrong(kBrick + turned + "*EQUATION\n2\n1,1,1.,2,1,-1.\n"),
              HasSubstr("*EQUATION of line 17 has a dof of node 1, whose directions *TRANSFORM turns"));
  EXPECT_THAT(
      wrong(kBrick + turned + "*ELEMENT, TYPE=SPRING2, ELSET=p\n20, 2,1\n*SPRING, ELSET=p\n1,1\n5.\n"),
      HasSubstr("element 20 has a dof of node 1, whose directions *TRANSFORM turns"));
  EXPECT_THAT(wrong("NODE\n" + kBrick), HasSubstr("body.inp:1:1: 'NODE' stands before the first keyword"));
  EXPECT_THAT(wrong("*NODE\r1,0,0,0\r"), HasSubstr("body.inp:1:1: ends its lines with CR alone"));
  EXPECT_THAT(wrong(kBrick + "*NSET, NSET=a, GENERATE\n4, 1\n"),
              HasSubstr("body.inp:13:1: the last number, 1, is below the first, 4"));
  const std::string beam =
      "*MATERIAL, NAME=m\n*ELASTIC\n1,0.3\n*BEAM SECTION, ELSET=b, MATERIAL=m, "
      "SECTION=RECT\n0.1,0.1\n1,0,0\n";
  EXPECT_THAT(wrong(kNodes + "*ELEMENT, TYPE=B31, ELSET=b\n7, 1,2\n" + beam),
              HasSubstr("body.inp:15:1: element 7 of the set b lies along the direction 1 of its section"));
  EXPECT_THAT(wrong(kNodes + "9,0,0,0\n*ELEMENT, TYPE=B31, ELSET=b\n7, 1,9\n" + beam),
              HasSubstr("body.inp:16:1: element 7 of the set b has no length"));
  EXPECT_THAT(wrong("*INCLUDE, INPUT=/etc/passwd\n"), HasSubstr("*INCLUDE is not allowed here"));
}

}  // namespace
}  // namespace mimbre::fe::inp_test
