#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <random>

#include "fe/solid_meshes.h"
#include "fe_files/fe_files.h"
#include "fe_files/inp/inp_model.h"
#include "fe_files/nastran/nastran.h"
#include "fe_files/nastran/nastran_model.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_reduce.h"

namespace mimbre::fe::nastran_mesh_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

ImportedMesh parse(const std::string& text) {
  TextFile file(text, "deck.bdf");
  return parse_nastran(file);
}

/// As people and programs write it.
enum class Form { free, small, large };

std::string card(Form form, const std::string& name, const std::vector<std::string>& fields) {
  std::string text = form == Form::large   ? fmt::format("{:<8}", name + "*")
                     : form == Form::small ? fmt::format("{:<8}", name)
                                           : name;
  const std::size_t per_line = form == Form::large ? 4 : 8;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (i > 0 && i % per_line == 0)
      text += form == Form::free ? ",\n" : form == Form::small ? "\n        " : "\n*       ";
    text +=
        form == Form::free ? "," + fields[i] : fmt::format("{:>{}}", fields[i], form == Form::small ? 8 : 16);
  }
  return text + "\n";
}

/// Frequencies of a free mesh, squared.
Eigen::VectorXd squares(SolidMesh mesh) {
  for (NamedMaterial& named : mesh.materials) named.material.density = 7800;
  for (BeamElement& beam : mesh.beams) beam.material.density = 7800;
  const FeMatrices matrices = assemble(mesh);
  return symmetric_eigenvalues(test::full(matrices.stiffness), test::full(matrices.mass));
}

void expect_same_frequencies(const SolidMesh& a, const SolidMesh& b, const std::string& what) {
  const Eigen::VectorXd one = squares(a), other = squares(b);
  ASSERT_EQ(one.size(), other.size()) << what;
  for (Eigen::Index i = 6; i < one.size(); ++i)
    EXPECT_NEAR(other[i] / one[i], 1, 2e-9) << what << " mode " << i;
}

struct CardType {
  ElementType type;
  const char* nastran;
  const char* inp;
  std::vector<int> order;  ///< of the card's nodes
};

const std::vector<CardType>& solid_cards() {
  static const std::vector<CardType> all{
      {ElementType::tet4, "CTETRA", "C3D4", {0, 1, 2, 3}},
      {ElementType::tet10, "CTETRA", "C3D10", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}},
      {ElementType::hex8, "CHEXA", "C3D8", {0, 1, 2, 3, 4, 5, 6, 7}},
      {ElementType::hex20, "CHEXA", "C3D20", {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,
                                              10, 11, 16, 17, 18, 19, 12, 13, 14, 15}},
      {ElementType::wedge6, "CPENTA", "C3D6", {0, 1, 2, 3, 4, 5}},
      {ElementType::wedge15, "CPENTA", "C3D15", {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11}},
      {ElementType::pyramid5, "CPYRAM", "", {0, 1, 2, 3, 4}},
      {ElementType::pyramid13, "CPYRAM", "", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}}};
  return all;
}

/// The bricks of a distorted block; places are multiples of 1/16, which few digits write.
SolidMesh block_of(ElementType type) {
  std::mt19937 random(7);
  return test::block(type, {2, 1, 1}, {2, 1, 1}, {2.1e11, 0.3, 7800}, [&](const Vector3d& at) {
    Vector3d moved = at;
    for (double& x : moved) x += static_cast<double>(random() % 4) / 16;
    return moved;
  });
}

std::string bdf(const SolidMesh& mesh, const CardType& type, Form form, bool mirrored = false) {
  std::string text = "SOL 103\nCEND\nSPC = 4\nBEGIN BULK\n$ of the test\n";
  text += card(form, "MAT1", {"3", "2.1E11", "", "0.3", "7800."}) + card(form, "PSOLID", {"8", "3"});
  for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n)
    text += card(form, "GRID",
                 {std::to_string(n + 1), "", fmt::format("{:#}", mesh.nodes(0, n)),
                  fmt::format("{:#}", mesh.nodes(1, n)), fmt::format("{:#}", mesh.nodes(2, n))});
  const int count = node_count(type.type);
  for (int e = 0; e < mesh.groups[0].size(); ++e) {
    std::vector<std::string> fields{std::to_string(100 + e), "8"};
    for (const int k : type.order) {
      // The other way round the first face.
      int place = k;
      if (mirrored)
        place = type.type == ElementType::hex8
                    ? std::array{0, 3, 2, 1, 4, 7, 6, 5}[static_cast<std::size_t>(k)]
                    : std::array{0, 2, 1, 3}[static_cast<std::size_t>(k)];
      fields.push_back(std::to_string(mesh.groups[0].nodes[static_cast<std::size_t>(e * count + place)] + 1));
    }
    text += card(form, type.nastran, fields);
  }
  return text + "SPC1,4,123,1,THRU,2\nENDDATA\nGRID,1\n";
}

std::string inp(const SolidMesh& mesh, const CardType& type) {
  std::string text = "*NODE\n";
  for (Eigen::Index n = 0; n < mesh.nodes.cols(); ++n)
    text += fmt::format("{},{},{},{}\n", n + 1, mesh.nodes(0, n), mesh.nodes(1, n), mesh.nodes(2, n));
  text += fmt::format("*ELEMENT, TYPE={}, ELSET=all\n", type.inp);
  const int count = node_count(type.type);
  for (int e = 0; e < mesh.groups[0].size(); ++e) {
    text += std::to_string(100 + e);
    for (int k = 0; k < count; ++k)
      text += fmt::format(",{}{}", k % 10 == 9 ? "\n" : "",
                          mesh.groups[0].nodes[static_cast<std::size_t>(e * count + k)] + 1);
    text += "\n";
  }
  return text +
         "*MATERIAL, NAME=steel\n*ELASTIC\n2.1e11,0.3\n*DENSITY\n7800\n*SOLID SECTION, ELSET=all, "
         "MATERIAL=steel\n";
}

TEST(NastranMesh, SolidsAreThoseOfTheSameMeshInInp) {
  Folder folder;
  for (const CardType& type : solid_cards()) {
    const SolidMesh mesh = block_of(type.type);
    const std::string inp_file = folder.path("a.inp");
    const SolidMesh wanted =
        *type.inp == '\0' ? mesh
                          : parse_inp(std::make_unique<TextFile>(inp(mesh, type), "a.inp"), "", false).mesh;
    for (const Form form : {Form::free, Form::small, Form::large}) {
      // The centres of the bricks have more digits than the small field.
      if (form == Form::small && test::corners_only(type.type) == ElementType::pyramid5) continue;
      const auto read = read_nastran(folder.write("a.bdf", bdf(mesh, type, form)));
      ASSERT_TRUE(read);
      ASSERT_EQ(read->mesh.nodes.cols(), mesh.nodes.cols());
      EXPECT_EQ((read->mesh.nodes - mesh.nodes).norm(), 0);
      EXPECT_EQ(read->mesh.groups[0].type, type.type);
      expect_same_frequencies(wanted, read->mesh, fmt::format("{} {}", type.nastran, static_cast<int>(form)));
    }
  }
}

TEST(NastranMesh, SolidsMayBeNumberedTheOtherWayRound) {
  for (const CardType& type : {solid_cards()[0], solid_cards()[2]}) {
    const SolidMesh mesh = block_of(type.type);
    Folder folder;
    const auto read = read_nastran(folder.write("a.bdf", bdf(mesh, type, Form::free, true)));
    expect_same_frequencies(mesh, read->mesh, type.nastran);
  }
}

const std::string kPlate =
    "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,2.,0.1,0.\nGRID,4,,0.,1.,0.\nGRID,5,,1.,1.,0.2\nGRID,6,,2.,"
    "1.,0.\n";
const std::string kPlateInp =
    "*NODE\n1,0,0,0\n2,1,0,0\n3,2,0.1,0\n4,0,1,0\n5,1,1,0.2\n6,2,1,0\n"
    "*MATERIAL, NAME=m\n*ELASTIC\n7e10,0.25\n*DENSITY\n2700\n";

TEST(NastranMesh, ShellsAreThoseOfTheSameMeshInInp) {
  const SolidMesh wanted =
      parse_inp(
          std::make_unique<TextFile>(
              kPlateInp +
                  "*ELEMENT, TYPE=S4, ELSET=q\n1,1,2,5,4\n*ELEMENT, TYPE=S3, ELSET=t\n2,2,3,6\n3,2,6,5\n"
                  "*SHELL SECTION, ELSET=q, MATERIAL=m\n0.02\n*SHELL SECTION, ELSET=t, MATERIAL=m\n0.03\n",
              "a.inp"),
          "", false)
          .mesh;
  const std::string shells = "CQUAD4,1,1,1,2,5,4\nCTRIA3,2,2,2,3,6\nCTRIA3,3,2,2,6,5\n";
  const std::string material = "MAT1,9,7.+10,,.25,2700.\n";
  expect_same_frequencies(
      wanted,
      parse(kPlate + shells + material + "PSHELL,1,9,0.02,9,,9\nPSHELL,2,9,0.03,9,1.,9,0.833333\n").mesh,
      "plain");
  // Thicknesses on the cards, as they are and as shares.
  expect_same_frequencies(
      wanted,
      parse(kPlate + material +
            "CQUAD4,1,2,1,2,5,4,,,\n,,,.02,.02,.02,.02\nCTRIA3,2,2,2,3,6\n"
            "CTRIA3,3,1,2,6,5,,,,\n,,1,1.5,1.5,1.5\nPSHELL,1,9,0.02,9,,9\nPSHELL,2,9,0.03,9,,9\n")
          .mesh,
      "thickness");
}

/// Nodes of a square of 2 × 2, row by row, the last amid the first side of a bend.
const char* const kSquareNodes =
    "1,0,0,0\n2,1,0,0.1\n3,2,0,0\n4,0,1,0\n5,1,1,0.1\n6,2,1,0\n7,0,2,0\n8,1,2,0.1\n9,2,2,0\n";

std::string square_grids() {
  std::string text = "MAT1,9,7.+10,,.25,2700.\nPSHELL,1,9,.02,9,,9\n";
  for (int n = 0; n < 9; ++n)
    text += fmt::format("GRID,{},,{}.,{}.,{}\n", n + 1, n % 3, n / 3, n % 3 == 1 ? ".1" : "0.");
  return text;
}

SolidMesh square_inp(const std::string& elements) {
  return parse_inp(std::make_unique<TextFile>("*NODE\n" + std::string(kSquareNodes) + elements +
                                                  "*MATERIAL, NAME=m\n*ELASTIC\n7e10,0.25\n*DENSITY\n2700\n"
                                                  "*SHELL SECTION, ELSET=s, MATERIAL=m\n0.02\n",
                                              "a.inp"),
                   "", false)
      .mesh;
}

TEST(NastranMesh, QuadraticShellsDoNotLock) {
  const std::string grids = square_grids();
  expect_same_frequencies(square_inp("*ELEMENT, TYPE=S8R, ELSET=s\n1,1,3,9,7,2,6,8,4\n"),
                          parse(grids + "CQUAD8,1,1,1,3,9,7,2,6,\n,8,4\n").mesh, "CQUAD8");
  const SolidMesh facets = square_inp(
      "*ELEMENT, TYPE=S3, ELSET=s\n1,1,2,5\n2,2,3,6\n3,5,6,9\n4,5,2,6\n5,4,1,5\n6,7,4,8\n7,8,5,9\n8,5,8,4\n");
  expect_same_frequencies(facets, parse(grids + "CTRIA6,1,1,1,3,9,2,6,5\nCTRIA6,2,1,1,9,7,5,8,4\n").mesh,
                          "CTRIA6");
  // Without nodes amid their sides they are linear ones.
  expect_same_frequencies(parse(grids + "CQUAD4,1,1,1,3,9,7\n").mesh,
                          parse(grids + "CQUAD8,1,1,1,3,9,7\n").mesh, "corners");
  expect_same_frequencies(parse(grids + "CTRIA3,1,1,1,3,9\nCTRIA3,2,1,1,9,7\n").mesh,
                          parse(grids + "CTRIA6,1,1,1,3,9\nCTRIA6,2,1,1,9,7\n").mesh, "corners");
  // Some of them: triangles on the nodes that there are.
  expect_same_frequencies(parse(grids + "CTRIA3,1,1,1,2,7\nCTRIA3,2,1,2,6,7\nCTRIA3,3,1,2,3,6\n"
                                        "CTRIA3,4,1,6,9,7\n")
                              .mesh,
                          parse(grids + "CQUAD8,1,1,1,3,9,7,2,6\n").mesh, "some");
}

/// A free square plate, a thousandth thick: A. W. Leissa, Vibration of Plates, table 4.69 (Poisson's
/// ratio 0.3): ω a² √(ρ h / D).
TEST(NastranMesh, ThinQuadraticShellsVibrateAsPlates) {
  const double thickness = 1e-3;
  for (const bool triangles : {false, true}) {
    constexpr int cells = 4, side = 2 * cells + 1;
    std::string text = fmt::format("MAT1,9,7.+10,,.3,7800.\nPSHELL,1,9,{},9,,9\n", thickness);
    for (int n = 0; n < side * side; ++n)
      text += fmt::format("GRID,{},,{:#},{:#},0.\n", n + 1, n % side / 8.0, n / side / 8.0);
    int label = 0;
    for (int i = 0; i < side - 1; i += 2)
      for (int j = 0; j < side - 1; j += 2) {
        const auto at = [&](int a, int b) { return (j + b) * side + i + a + 1; };
        if (triangles)
          for (const bool first : {true, false})
            text +=
                fmt::format("CTRIA6,{},1,{},{},{},{},{},{}\n", ++label, at(0, 0), first ? at(2, 0) : at(2, 2),
                            first ? at(2, 2) : at(0, 2), first ? at(1, 0) : at(1, 1),
                            first ? at(2, 1) : at(1, 2), first ? at(1, 1) : at(0, 1));
        else
          text += fmt::format("CQUAD8,{},1,{},{},{},{},{},{},\n,{},{}\n", ++label, at(0, 0), at(2, 0),
                              at(2, 2), at(0, 2), at(1, 0), at(2, 1), at(1, 2), at(0, 1));
      }
    const Eigen::VectorXd found = squares(parse(text).mesh);
    const double D = 7e10 * std::pow(thickness, 3) / (12 * (1 - 0.09));
    const double wanted[] = {13.468, 19.596, 24.270, 34.801, 34.801};
    for (int k = 0; k < 5; ++k)
      EXPECT_NEAR(std::sqrt(found[6 + k] * 7800 * thickness / D) / wanted[k], 1, 0.01)
          << (triangles ? "CTRIA6" : "CQUAD8") << " mode " << k;
  }
}

TEST(NastranMesh, BarsAreThoseOfTheSameMeshInInp) {
  const SolidMesh wanted =
      parse_inp(
          std::make_unique<TextFile>(
              "*NODE\n1,0,0,0\n2,1,0.5,0\n3,1,2,0.25\n*MATERIAL, "
              "NAME=m\n*ELASTIC\n7e10,0.25\n*DENSITY\n2700\n"
              "*ELEMENT, TYPE=B31, ELSET=b\n1,1,2\n2,2,3\n*BEAM SECTION, ELSET=b, MATERIAL=m, SECTION=RECT\n"
              "0.02,0.05\n0,0,1\n",
              "a.inp"),
          "", false)
          .mesh;
  ASSERT_EQ(wanted.beams.size(), 2u);
  const Section& s = wanted.beams[0].section;
  // The shear factors of the same bar; none where it has no shear deformation.
  const std::string shear =
      s.shear_y > 0 ? fmt::format(",,\n,,,,,,,,\n,{},{}", s.shear_y / s.area, s.shear_z / s.area) : "";
  const std::string rest =
      fmt::format("MAT1,9,7.+10,,.25,2700.\nPBAR,1,9,{},{},{},{}{}\n", s.area, s.Iz, s.Iy, s.J, shear);
  const std::string grids = "GRID,1,,0.,0.,0.\nGRID,2,,1.,.5,0.\nGRID,3,,1.,2.,.25\n";
  expect_same_frequencies(wanted, parse(grids + rest + "CBAR,1,1,1,2,0.,0.,1.\nCBAR,2,1,2,3,0.,0.,1.\n").mesh,
                          "vector");
  // The direction by a node, and by default; a vector in the system of displacements of the first node.
  expect_same_frequencies(
      wanted,
      parse(grids + rest + "GRID,7,,0.,0.,5.\nCBAR,1,1,1,2,7\nCBAR,2,1,2,3\nBAROR,,,,,0.,0.,1.\n").mesh,
      "node");
  expect_same_frequencies(
      wanted,
      parse("CORD2R,4,,0.,0.,0.,1.,0.,0.\n,0.,0.,1.\nGRID,1,,0.,0.,0.,4\nGRID,2,,1.,.5,0.,4\n"
            "GRID,3,,1.,2.,.25,4\n" +
            rest + "CBAR,1,1,1,2,1.,0.,0.\nCBAR,2,1,2,3,1.,0.,0.\n")
          .mesh,
      "displacement system");
}

TEST(NastranMesh, UnsymmetricSectionsHavePrincipalAxes) {
  // An angle iron turned by 30°: the same bar, whether its axes are turned or its moments.
  const double a = std::numbers::pi / 6, c = std::cos(a), s = std::sin(a), I1 = 4e-8, I2 = 1e-8;
  const std::string head =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nMAT1,9,7.+10,,.25,2700.\nCBAR,2,1,2,3,0.,0.,1."
      "\n";
  const SolidMesh principal =
      parse(head + fmt::format("CBAR,1,1,1,2,0.,{},{}\nCBAR,3,1,2,3,0.,0.,1.\n", c, s) +
            fmt::format("PBAR,1,9,1.-4,{},{},2.-8\n", I1, I2))
          .mesh;
  const double turned1 = I1 * c * c + I2 * s * s, turned2 = I1 * s * s + I2 * c * c, I12 = (I1 - I2) * c * s;
  SolidMesh turned =
      parse(head +
            fmt::format("CBAR,1,2,1,2,0.,1.,0.\nCBAR,3,1,2,3,0.,0.,1.\nPBAR,1,9,1.-4,{},{},2.-8\n", I1, I2) +
            fmt::format("PBAR,2,9,1.-4,{},{},2.-8,,,\n,,,,,,,,\n,,,{}\n", turned1, turned2, I12))
          .mesh;
  expect_same_frequencies(principal, turned, "I12");
}

TEST(NastranSections, HaveTheirAreasAndMoments) {
  const NastranSection bar = nastran_section("BAR", {0.02, 0.05});
  EXPECT_NEAR(bar.I1, 0.02 * std::pow(0.05, 3) / 12, 1e-20);
  EXPECT_NEAR(bar.I2, 0.05 * std::pow(0.02, 3) / 12, 1e-20);
  const NastranSection box = nastran_section("BOX", {0.1, 0.2, 0.01, 0.005});
  EXPECT_NEAR(box.area, 0.1 * 0.2 - 0.09 * 0.18, 1e-15);
  EXPECT_NEAR(box.I1, (0.1 * std::pow(0.2, 3) - 0.09 * std::pow(0.18, 3)) / 12, 1e-15);
  EXPECT_NEAR(box.I2, (0.2 * std::pow(0.1, 3) - 0.18 * std::pow(0.09, 3)) / 12, 1e-15);
  const NastranSection i = nastran_section("I", {0.2, 0.1, 0.1, 0.005, 0.01, 0.01});
  const NastranSection i1 = nastran_section("I1", {0.095, 0.005, 0.18, 0.2});
  for (const NastranSection& s : {i, i1}) {
    EXPECT_NEAR(s.I1, (0.1 * std::pow(0.2, 3) - 0.095 * std::pow(0.18, 3)) / 12, 1e-15);
    EXPECT_NEAR(s.I2, (0.02 * std::pow(0.1, 3) + 0.18 * std::pow(0.005, 3)) / 12, 1e-15);
    EXPECT_EQ(s.I12, 0);
  }
  // A Z is the same turned by half a turn, so that its moments are about its middle; its flanges lie across.
  const NastranSection z = nastran_section("Z", {0.05, 0.01, 0.08, 0.1});
  EXPECT_NEAR(z.centroid.norm(), 0, 1e-15);
  EXPECT_NEAR(z.I12, -2 * 0.05 * 0.01 * 0.045 * 0.03, 1e-15);
  EXPECT_NEAR(nastran_section("TUBE", {0.1, 0.09}).J, std::numbers::pi / 2 * (1e-4 - std::pow(0.09, 4)),
              1e-15);
  EXPECT_THROW(nastran_section("BOX", {0.1, 0.1, 0.06, 0.01}), std::invalid_argument);
  EXPECT_THROW(nastran_shape_sizes("DBOX"), std::invalid_argument);
}

/// E. P. Popov, Mechanics of Materials: of a channel 3 b² t_f/(h t_w + 6 b t_f) behind its web; nodes of a
/// CBEAM are there, those of a CBAR at the centroid.
TEST(NastranSections, BeamsLieAtTheirShearCentre) {
  const std::string nodes = "GRID,1,,0.,0.,0.\nGRID,2,,5.,0.,0.\nMAT1,1,1.,,.3,1.\n";
  // CHAN: flanges 0.1, height 0.2, web 0.01, flanges' walls 0.01.
  const std::string sizes = ",0.1,0.2,0.01,0.01\n";
  const double b = 0.1 - 0.005, h = 0.19, t = 0.01, e = 3 * b * b * t / (h * t + 6 * b * t);
  const double centroid = (2 * 0.1 * 0.01 * 0.05 + 0.18 * 0.01 * 0.005) / (2 * 0.1 * 0.01 + 0.18 * 0.01);
  const ImportedMesh beam = parse(nodes + "CBEAM,1,1,1,2,0.,1.,0.\nPBEAML,1,1,,CHAN\n" + sizes);
  ASSERT_EQ(beam.mesh.beams.size(), 1u);
  for (const Eigen::Vector3d& arm : beam.mesh.beams[0].offsets)
    EXPECT_LT((arm - Eigen::Vector3d(0, 0, centroid - (0.005 - e))).norm(), 1e-12);
  bool said = false;
  for (const Diagnostic& warning : beam.warnings)
    said = said || warning.message.find("off the shear centre") != std::string::npos;
  EXPECT_TRUE(said);
  const ImportedMesh bar = parse(nodes + "CBAR,1,1,1,2,0.,1.,0.\nPBARL,1,1,,CHAN\n" + sizes);
  for (const Eigen::Vector3d& arm : bar.mesh.beams.at(0).offsets) EXPECT_EQ(arm.norm(), 0);
}

TEST(NastranSystems, PlacesAreThoseOfTheBasicSystem) {
  const SolidMesh mesh =
      parse(
          // 1: cylindrical, its axis along x at z = 3; 2: spherical in 1, at r = 2, θ = 90°; 3: by nodes.
          "CORD2C,1,,0.,0.,3.,1.,0.,3.\n,0.,1.,3.\nCORD2S,2,1,2.,90.,0.,2.,90.,1.\n,3.,90.,0.\n"
          "CORD1R,3,1,2,4\nGRDSET,,1\n"
          "GRID,1,,2.,0.,5.\nGRID,2,,2.,90.,5.\nGRID,3,2,1.,90.,0.\nGRID,4,0,0.,0.,0.\nGRID,5,2,2.,0.,0.\n"
          "GRID,6,3,0.,0.,2.\nMAT1,1,1.,,.3,1.\nPSOLID,1,1\nCTETRA,1,1,1,2,3,4\n")
          .mesh;
  EXPECT_LT((mesh.nodes.col(0) - Vector3d(5, 2, 3)).norm(), 1e-15);
  EXPECT_LT((mesh.nodes.col(1) - Vector3d(5, 0, 5)).norm(), 1e-15);
  EXPECT_EQ((mesh.nodes.col(3) - Vector3d(0, 0, 0)).norm(), 0);
  // The origin of 2 is (0, 0, 5); its z runs along x, its x on outwards (z).
  EXPECT_LT((mesh.nodes.col(2) - Vector3d(0, 0, 6)).norm(), 1e-15);
  EXPECT_LT((mesh.nodes.col(4) - Vector3d(2, 0, 5)).norm(), 1e-15);
  // 3: from node 1 towards node 2.
  EXPECT_LT((mesh.nodes.col(5) - (Vector3d(5, 2, 3) + 2 * Vector3d(0, -1, 1).normalized())).norm(), 1e-14);
}

/// Displacement or rotation of a node in the rigid motion (translation, rotation about the origin).
double rigid(const SolidMesh& mesh, const LinearTerm& term, const Vector3d& shift, const Vector3d& turn) {
  return term.direction < 3 ? (shift + turn.cross(Vector3d(mesh.nodes.col(term.node))))[term.direction]
                            : turn[term.direction - 3];
}

TEST(NastranTies, RigidMotionsNeitherStretchSpringsNorBreakEquations) {
  std::mt19937 random(3);
  const auto number = [&] { return static_cast<double>(random() % 2000) / 1000 - 1; };
  std::size_t equations = 0, springs = 0;
  for (int deck = 0; deck < 40; ++deck) {
    std::string text = fmt::format("CORD2C,5,,{},{},{},{},{},{}\n,{},{},{}\n", number(), number(), number(),
                                   number() + 3, number(), number(), number(), number() + 3, number());
    text += fmt::format("CORD2S,6,,{},{},{},{},{},{}\n,{},{},{}\n", number(), number(), number(),
                        number() + 3, number(), number(), number(), number() + 3, number());
    for (int n = 1; n <= 8; ++n)
      text += fmt::format("GRID,{},,{},{},{},{}\n", n, number(), number(), number(),
                          random() % 3 == 0 ? 0 : 5 + random() % 2);
    text += "GRID,9,,1.,2.,3.,5\nGRID,10,,1.,2.,3.,5\n";
    text += "MAT1,1,1.,,.3,1.\nPSHELL,1,1,.1,1,,1\nCQUAD4,1,1,1,2,3,4\nCQUAD4,2,1,5,6,7,8\n";
    text += "CBAR,3,1,1,5,1.,2.,.3,,\n,456,5,.1,.2,.3,-.1,.2\nPBAR,1,1,1.,1.,2.,3.\n";
    text +=
        "CBAR,4,2,2,6,1.,2.,.3,,\n,,,.1,.2,.3,-.1,.2\nPBAR,2,1,1.,1.,2.,,,,\n,,,,,,,,\n,.8,.9,.5\n";  // J =
                                                                                                      // 0:
                                                                                                      // springs
    text += "RBE2,10,1,1246,2,3\nRBE2,11,4,123456,5\nRBE3,12,,6,12356,1.,123,1,2,,\n,3,.5,1,4\n";
    text += "RBE3,13,,7,123456,1.,123456,1,2,3\nRROD,14,8,3\nRBAR,15,1,8,123456,,,1235\n";
    text += "CBUSH,20,7,1,8,1.,2.,3.\nPBUSH,7,K,1.,2.,3.,4.,5.,6.\nCBUSH,21,7,2,7,,,,6\n,.3\n";
    text += "CELAS2,22,5.,9,1,10,1\nCELAS2,23,5.,9,5,10,5\nCROD,24,3,1,7\nPROD,3,1,2.,3.\n";
    text += fmt::format("GRID,31,,0.,0.,{}\nGRID,32,,1.,{},{}\nGRID,33,,1.,1.,0.\nGRID,34,,{},1.,0.\n",
                        number() / 4, number() / 4, number() / 4, number() / 4);
    text += "CSHEAR,25,4,31,32,33,34\nPSHEAR,4,1,.1\n";
    const SolidMesh mesh = parse(text).mesh;
    for (int motion = 0; motion < 6; ++motion) {
      const Vector3d shift = motion < 3 ? Vector3d(Vector3d::Unit(motion)) : Vector3d(Vector3d::Zero());
      const Vector3d turn = motion < 3 ? Vector3d(Vector3d::Zero()) : Vector3d(Vector3d::Unit(motion - 3));
      const auto sum = [&](const std::vector<LinearTerm>& terms) {
        double value = 0, size = 0;
        for (const LinearTerm& term : terms) {
          value += term.factor * rigid(mesh, term, shift, turn);
          size += std::abs(term.factor);
        }
        return std::abs(value) / size;
      };
      for (const Equation& equation : mesh.equations) EXPECT_LT(sum(equation.terms), 1e-10) << equation.name;
      for (const Spring& spring : mesh.springs) EXPECT_LT(sum(spring.stretch), 1e-10) << spring.name;
    }
    equations += mesh.equations.size();
    springs += mesh.springs.size();
  }
  EXPECT_GT(equations, 40u * 15);
  EXPECT_GT(springs, 40u * 18);
}

/// A bush from a shell to a node of its own: both turn, or the body would hang on a spring to nothing.
TEST(NastranTies, BushesTurnNodesThatNothingElseTurns) {
  const std::string shell =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nGRID,5,,0.,0.,0.\n"
      "MAT1,1,1.,,.3,1.\nPSHELL,1,1,.1,1,,1\nCQUAD4,1,1,1,2,3,4\nPBUSH,7,K,1.,2.,3.,4.,5.,6.\n";
  const SolidMesh mesh = parse(shell + "CBUSH,20,7,5,1,,,,0\n").mesh;
  ASSERT_EQ(mesh.springs.size(), 6u);
  for (const Spring& spring : mesh.springs) EXPECT_EQ(spring.stretch.size(), 2u);
}

/// A rod that hangs down from a shell carries its end along its length; across, the end goes with the shell.
TEST(NastranTies, EndsOfRodsGoWithTheBodyAcrossTheRod) {
  const ImportedMesh read = parse(
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nGRID,5,,0.,0.,-2.\n"
      "GRID,6,,0.,.5,-3.\nGRID,7,,9.,9.,9.\n"
      "MAT1,1,1.,,.3,1.\nPSHELL,1,1,.1,1,,1\nCQUAD4,1,1,1,2,3,4\nPROD,3,1,2.\nCROD,24,3,1,5\nCROD,25,3,5,6\n"
      "CONM2,9,7,,5.\n");
  const SolidMesh& mesh = read.mesh;
  ASSERT_EQ(mesh.equations.size(), 3u);  // 5 has two rods, 6 one
  for (const Equation& equation : mesh.equations) {
    // Rigid motions satisfy it, and it says nothing of the direction in which the rods hold.
    for (int motion = 0; motion < 6; ++motion) {
      const Vector3d shift = motion < 3 ? Vector3d(Vector3d::Unit(motion)) : Vector3d(Vector3d::Zero());
      const Vector3d turn = motion < 3 ? Vector3d(Vector3d::Zero()) : Vector3d(Vector3d::Unit(motion - 3));
      double sum = 0;
      for (const LinearTerm& term : equation.terms) sum += term.factor * rigid(mesh, term, shift, turn);
      EXPECT_NEAR(sum, 0, 1e-12);
    }
    Vector3d across = Vector3d::Zero();
    for (const LinearTerm& term : equation.terms)
      if (term.node == equation.terms[0].node) across[term.direction] = term.factor;
    EXPECT_NEAR(across.dot(Vector3d(0, .5, -1)), 0, 1e-12);
    if (equation.terms[0].node == 4) {
      EXPECT_NEAR(across.z(), 0, 1e-12);
    }
  }
  // The lone mass is left out.
  for (const PointMass& point : mesh.point_masses) EXPECT_NE(point.node, 6);
  bool said = false;
  for (const Diagnostic& warning : read.warnings)
    said = said || warning.message.find("first at node 7") != std::string::npos;
  EXPECT_TRUE(said);
}

/// A mass that equations hold along x and y alone: along z it goes with the body, so that the body has its
/// mass in all directions.
TEST(NastranTies, MassesOnEquationsGoWithTheBodyWhereNoneHoldsThem) {
  const SolidMesh mesh =
      parse(
          "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nGRID,5,,1.,1.,0.\n"
          "MAT1,1,1.,,.3,1.\nPSHELL,1,1,.1,1,,1\nCQUAD4,1,1,1,2,3,4\nCONM2,9,5,,5.\n"
          "MPC,1,3,1,-1.,5,1,1.\nMPC,1,3,2,-1000.,5,2,1000.\n")
          .mesh;
  ASSERT_EQ(mesh.equations.size(), 3u);
  const Equation& across = mesh.equations.back();
  EXPECT_EQ(across.terms.front().node, 4);
  EXPECT_EQ(across.terms.front().direction, 2);
  for (int motion = 0; motion < 6; ++motion) {
    const Vector3d shift = motion < 3 ? Vector3d(Vector3d::Unit(motion)) : Vector3d(Vector3d::Zero());
    const Vector3d turn = motion < 3 ? Vector3d(Vector3d::Zero()) : Vector3d(Vector3d::Unit(motion - 3));
    double sum = 0;
    for (const LinearTerm& term : across.terms) sum += term.factor * rigid(mesh, term, shift, turn);
    EXPECT_NEAR(sum, 0, 1e-12);
  }
}

/// Rows of rods of any order, of thousands of nodes: the search for what they hang on is one for all.
TEST(NastranTies, LongRowsOfRodsHangOnTheBody) {
  constexpr int count = 3000;
  std::string text =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nMAT1,1,1.,,.3,1.\n"
      "PSHELL,1,1,.1,1,,1\nCQUAD4,1,1,1,2,3,4\nPROD,3,1,2.,1.\nPBUSH,7,K,,,,1.\n";
  for (int k = 1; k <= count; ++k) text += fmt::format("GRID,{},,0.,0.,-{}.\n", 4 + k, k);
  for (int k = count; k > 1; --k) text += fmt::format("CROD,{},3,{},{}\n", 10 + k, 4 + k, 3 + k);
  text += "CROD,5,3,1,5\nCBUSH,6,7,1,5,,,,0\n";
  const SolidMesh mesh = parse(text).mesh;
  EXPECT_EQ(mesh.equations.size(), 2u * count);
  for (const Equation& equation : mesh.equations) EXPECT_GE(equation.terms.front().node, 4);
}

/// Lowest free frequencies of a brick with `more`, held at two nodes amid.
Eigen::VectorXd free_frequencies(const std::string& more, const std::vector<int>& interface) {
  std::string text = "MAT1,1,2.1E11,,.3,7800.\nPSOLID,1,1\nMAT1,2,2.1E11,,.3\nPROD,5,2,1.E-4\n";
  for (int k = 0; k < 12; ++k)
    text += fmt::format("GRID,{},,{},{},{}\n", k + 1, (k % 4 == 1 || k % 4 == 2) ? "1." : "0.",
                        k % 4 > 1 ? "1." : "0.", fmt::format("{}.", k / 4));
  for (int k = 0; k < 2; ++k)
    text += fmt::format("CHEXA,{},1,{},{},{},{},{},{},\n,{},{}\n", k + 1, 4 * k + 1, 4 * k + 2, 4 * k + 3,
                        4 * k + 4, 4 * k + 5, 4 * k + 6, 4 * k + 7, 4 * k + 8);
  const SolidMesh mesh = parse(text + more).mesh;
  ModelReduction options;
  options.interfaces.resize(1);
  options.interfaces[0].name = "base";
  options.interfaces[0].nodes = interface;
  options.interfaces[0].point = mesh.nodes.col(interface[0]);
  options.dynamic_modes = 2;
  options.free_modes = 4;
  return reduce(mesh, assemble(mesh), options).free_frequencies;
}

/// A bar without mass between nodes of solids turns about itself without stiffness; it is a rod then,
/// whatever holds the body.
TEST(NastranTies, BarsThatTurnAboutThemselvesAreRods) {
  const Eigen::VectorXd rod = free_frequencies("CROD,9,5,1,7\n", {4, 5, 6});
  for (const std::vector<int>& interface : {std::vector<int>{4, 5, 6}, {0, 1, 2}, {6, 9, 10}}) {
    const Eigen::VectorXd bar =
        free_frequencies("PBAR,6,2,1.E-4,1.E-9,2.E-9,3.E-9\nCBAR,9,6,1,7,.3,-1.,.1\n", interface);
    ASSERT_EQ(bar.size(), rod.size());
    for (Eigen::Index k = 0; k < rod.size(); ++k) EXPECT_NEAR(bar[k] / rod[k], 1, 1e-9) << k;
  }
}

/// A table on two legs and two rods: held at its feet, the rods must not hold it across their length as a
/// foot would that goes with the table. The same as with the rods' feet on a rigid floor.
TEST(NastranTies, FeetOfRodsInAnInterfaceGoWithIt) {
  const auto held = [](const std::string& more, const std::vector<int>& feet) {
    const SolidMesh mesh =
        parse(
            "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nGRID,5,,0.,0.,-1.\n"
            "GRID,6,,1.,0.,-1.\nGRID,7,,1.,1.,-1.\nGRID,8,,0.,1.2,-1.\nMAT1,1,2.E11,,.3,7800.\n"
            "PSHELL,1,1,.02,1,,1\nCQUAD4,1,1,1,2,3,4\nPBAR,2,1,4.E-4,2.E-8,2.E-8,3.E-8\nPROD,3,1,1.E-4\n"
            "CBAR,2,2,1,5,1.,1.,0.\nCBAR,3,2,2,6,1.,1.,0.\nCROD,4,3,3,7\nCROD,5,3,4,8\n" +
            more)
            .mesh;
    ModelReduction options;
    options.interfaces.resize(1);
    options.interfaces[0].name = "feet";
    options.interfaces[0].nodes = feet;
    options.interfaces[0].point = mesh.nodes.col(feet[0]);
    options.dynamic_modes = 4;
    options.free_modes = 2;
    return reduce(mesh, assemble(mesh), options);
  };
  const ReductionResult rods = held("", {4, 5, 6, 7}), floor = held("RBE2,9,5,123456,7,8\n", {4, 5});
  for (Eigen::Index k = 0; k < 4; ++k)
    EXPECT_NEAR(rods.fixed_frequencies[k] / floor.fixed_frequencies[k], 1, 1e-9) << k;
  // Free, the feet of the rods do not swing either.
  EXPECT_GT(rods.free_frequencies[0], 0.1 * rods.fixed_frequencies[0]);
}

/// The interface's nodes have a rotation that nothing resists and that has no mass.
TEST(NastranTies, InterfacesMayHaveRotationsWithoutStiffness) {
  const Eigen::VectorXd rod = free_frequencies("CROD,9,5,1,5\n", {0, 1, 2}),
                        bar = free_frequencies("PBAR,6,2,1.E-4,1.E-9,2.E-9\nCBAR,9,6,1,5,1.,0.,0.\n",
                                               {0, 1, 2});
  for (Eigen::Index k = 0; k < rod.size(); ++k) EXPECT_NEAR(bar[k] / rod[k], 1, 1e-9) << k;
}

TEST(NastranTies, CoverWhatTheirCardsSay) {
  const SolidMesh mesh =
      parse(
          "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nGRID,5,,0.,0.,2.\nGRID,6,,"
          "0.,0.,3.\n"
          "MAT1,1,1.,,.3,1.\nPSHELL,1,1,.1,1,,1\nCQUAD4,1,1,1,2,3,4\nPARAM,WTMASS,0.5\n"
          "RBE2,10,5,123456,1,THRU,3\nRBE3,12,,6,123,1.5,123,1,2\n,3,4\n"
          "CORD2R,7,,0.,0.,0.,1.,0.,0.\n,0.,1.,0.\nCONM2,20,5,7,2.,1.,2.,3.\n,4.,.1,5.,.2,.3,6.\n"
          "CMASS2,21,3.,4,1\nCMASS2,22,3.,4,2\nCMASS2,23,3.,4,3\nSET1,4,1,THRU,3\n")
          .mesh;
  ASSERT_EQ(mesh.rigid_elements.size(), 1u);
  EXPECT_EQ(mesh.rigid_elements[0].reference, 4);
  EXPECT_THAT(mesh.rigid_elements[0].nodes, ElementsAre(0, 1, 2));
  ASSERT_EQ(mesh.mean_elements.size(), 1u);
  EXPECT_THAT(mesh.mean_elements[0].weights, ElementsAre(1.5, 1.5, 1.5, 1.5));
  EXPECT_THAT(mesh.mean_elements[0].follows, ElementsAre(true, true, true, false, false, false));
  ASSERT_EQ(mesh.point_masses.size(), 2u);
  // The axes of 7: z along x, x along y, y along z.
  const PointMass& mass = mesh.point_masses[0];
  EXPECT_EQ(mass.mass, 1);
  EXPECT_LT((mass.offset - Vector3d(3, 1, 2)).norm(), 1e-15);
  Matrix3d inertia;
  inertia << 6, -.2, -.3, -.2, 4, -.1, -.3, -.1, 5;
  EXPECT_LT((mass.inertia - inertia / 2).norm(), 1e-15);
  EXPECT_EQ(mesh.point_masses[1].mass, 1.5);
  EXPECT_EQ(mesh.materials[0].material.density, 0.5);
  std::vector<std::string> names;
  for (const NodeSet& set : mesh.node_sets) names.push_back(set.name);
  EXPECT_THAT(names, testing::UnorderedElementsAre("SET1:4", "PSHELL:1", "RBE2:10", "RBE3:12"));
}

/// Stiffness of the sheets of a shell against stretching, coupling and bending.
struct Sum {
  Matrix3d A = Matrix3d::Zero(), B = Matrix3d::Zero(), D = Matrix3d::Zero();
  double mass = 0;
};

Sum of_sheets(const SolidMesh& mesh) {
  Sum sum;
  for (const ElementGroup& group : mesh.groups) {
    const NamedMaterial& named = mesh.materials[static_cast<std::size_t>(group.material)];
    Matrix3d Q;
    const std::array plane{0, 1, 3};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        Q(i, j) =
            named.elastic.value()(plane[static_cast<std::size_t>(i)], plane[static_cast<std::size_t>(j)]);
    const double t = group.thickness, z = group.offset;
    EXPECT_GT(symmetric_eigenvalues(Q)[0], 0);
    EXPECT_GT(named.material.density, 0);
    sum.A += t * Q;
    sum.B += t * z * Q;
    sum.D += (t * z * z + t * t * t / 12) * Q;
    sum.mass += t * named.material.density;
  }
  return sum;
}

TEST(NastranPanels, RectanglesAndParallelogramsHaveTheEnergyOfTheirShear) {
  for (const double skew : {0.0, 0.5}) {
    const SolidMesh mesh =
        parse(fmt::format("GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.\nGRID,3,,{},1.,0.\nGRID,4,,{},1.,0.\n"
                          "CSHEAR,1,1,1,2,3,4\nPSHEAR,1,1,.1,3.\nMAT1,1,2.6,,.3,10.\n",
                          2 + skew, skew))
            .mesh;
    ASSERT_EQ(mesh.springs.size(), 1u);
    // Forces q along the sides: the energy by forces is that of Garvey.
    const Spring& spring = mesh.springs[0];
    double along = 0;  // force at the corners of the lower side
    for (const LinearTerm& term : spring.stretch)
      if (term.node < 2 && term.direction == 0) along += term.factor;
    const double q =
        std::abs(along) / 2;  // of the sides that go up a half has −skew of their force, which cancels
    const double area = 2, tangent = skew;
    const double flexibility = q * q * area / (1 * 0.1) * (1 + 2 / 1.3 * tangent * tangent);
    EXPECT_NEAR(spring.stiffness * flexibility, 1, 1e-12) << skew;
    double mass = 0;
    for (const PointMass& point : mesh.point_masses) mass += point.mass;
    EXPECT_NEAR(mass, area * (10 * 0.1 + 3), 1e-12);
  }
}

/// A strain along a side stretches the rods of that side and the one across from it, as much as it would
/// stretch the sheet (a factor of 1) or strips of so many half thicknesses (above 1.01).
TEST(NastranPanels, RodsAlongTheSidesCarryNormalForces) {
  const auto energy = [](const std::string& factors, int direction) {
    const SolidMesh mesh = parse(
                               "GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.\nGRID,3,,2.,1.,0.\nGRID,4,,0.,1.,0.\n"
                               "CSHEAR,1,1,1,2,3,4\nPSHEAR,1,1,.1,," +
                               factors + "\nMAT1,1,2.6,,.3,10.\n")
                               .mesh;
    double sum = 0;
    for (const Spring& spring : mesh.springs) {
      double stretch = 0;
      for (const LinearTerm& term : spring.stretch)
        if (term.direction == direction) stretch += term.factor * mesh.nodes(direction, term.node);
      sum += spring.stiffness * stretch * stretch / 2;
    }
    return sum;
  };
  const double E = 2.6, t = 0.1, area = 2;
  EXPECT_NEAR(energy("0.,0.", 0), 0, 1e-14);
  EXPECT_NEAR(energy("1.,0.", 0), E * t * area / 2, 1e-13);
  EXPECT_NEAR(energy("1.,0.", 1), 0, 1e-14);
  EXPECT_NEAR(energy("0.,.5", 1), 0.5 * E * t * area / 2, 1e-13);
  EXPECT_NEAR(energy("30.,0.", 0), 2 * (E * 30 * t * t / 2) * 2 / 2, 1e-13);
  EXPECT_THAT(complaint([&] { energy("-1.,0.", 0); }), HasSubstr("must not be negative"));
}

TEST(NastranLaminates, HaveTheStiffnessOfTheirPlies) {
  const double E1 = 140e9, E2 = 10e9, nu = 0.3, G = 5e9, d = 1 - nu * nu * E2 / E1;
  const auto ply = [&](double degrees) {
    const double c = std::cos(degrees * std::numbers::pi / 180),
                 s = std::sin(degrees * std::numbers::pi / 180);
    Matrix3d Q, T;
    Q << E1 / d, nu * E2 / d, 0, nu * E2 / d, E2 / d, 0, 0, 0, G;
    T << c * c, s * s, c * s, s * s, c * c, -c * s, -2 * c * s, 2 * c * s, c * c - s * s;
    return Matrix3d(T.transpose() * Q * T);
  };
  const auto expect = [&](const std::string& plies, const std::vector<double>& angles) {
    const std::string text =
        "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nCQUAD4,1,1,1,2,3,4\n"
        "MAT8,5,140.+9,10.+9,.3,5.+9,5.+9,4.+9,1600.\n" +
        plies;
    const SolidMesh mesh = parse(text).mesh;
    Sum wanted;
    const double t = 1e-3;
    double z = -t * static_cast<double>(angles.size()) / 2;
    for (const double angle : angles) {
      const Matrix3d Q = ply(angle);
      wanted.A += t * Q;
      wanted.B += (std::pow(z + t, 2) - z * z) / 2 * Q;
      wanted.D += (std::pow(z + t, 3) - std::pow(z, 3)) / 3 * Q;
      z += t;
    }
    const Sum got = of_sheets(mesh);
    const double coupled = std::sqrt(wanted.A.norm() * wanted.D.norm());
    EXPECT_LT((got.A - wanted.A).norm(), 1e-12 * wanted.A.norm()) << plies;
    EXPECT_LT((got.B - wanted.B).norm(), 1e-12 * coupled) << plies;
    EXPECT_LT((got.D - wanted.D).norm(), 1e-12 * wanted.D.norm()) << plies;
    EXPECT_NEAR(got.mass, 1600 * t * static_cast<double>(angles.size()), 1e-10);
  };
  expect("PCOMP,1,,,,,,,\n,5,1.-3,0.\n", {0});
  expect("PCOMP,1,,,,,,,SYM\n,5,1.-3,0.,,5,1.-3,90.\n", {0, 90, 90, 0});
  expect("PCOMP,1,,,,,,,SYM\n,5,1.-3,0.,,5,1.-3,45.\n,,,-45.,,,,90.\n", {0, 45, -45, 90, 90, -45, 45, 0});
  expect("PCOMP,1,,,,,,,\n,5,1.-3,0.,,5,1.-3,90.\n", {0, 90});
  expect("PCOMPG,1,,,,,,,\n,1,5,1.-3,30.\n,2,5,1.-3,-60.\n", {30, -60});
}

/// As MID3 a MAT2 holds the stiffness against transverse shear in G11, G12 and G22.
TEST(NastranLaminates, TransverseShearOfItsOwnMaterial) {
  const SolidMesh mesh = parse(
                             "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\n"
                             "CQUAD4,1,1,1,2,3,4\nPSHELL,1,1,.1,1,,2,.5\nMAT1,1,2.6,,.3,1.\n"
                             "MAT2,2,3.,.5,,7.\n")
                             .mesh;
  double zx = 0, yz = 0, both = 0;
  for (const ElementGroup& group : mesh.groups) {
    const auto& C = mesh.materials[static_cast<std::size_t>(group.material)].elastic.value();
    zx += 5.0 / 6 * group.thickness * C(5, 5);
    yz += 5.0 / 6 * group.thickness * C(4, 4);
    both += 5.0 / 6 * group.thickness * C(4, 5);
  }
  EXPECT_NEAR(zx, .5 * .1 * 3, 1e-15);
  EXPECT_NEAR(yz, .5 * .1 * 7, 1e-15);
  EXPECT_NEAR(both, .5 * .1 * .5, 1e-15);
}

TEST(NastranLaminates, SandwichesBendByTheirFaces) {
  const SolidMesh mesh =
      parse(
          "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nCQUAD4,1,1,1,2,3,4\n"
          "MAT1,1,7.+10,,.3,2700.\nMAT1,2,,4.+8,.3\nPSHELL,1,1,1.-3,1,300.,2,10.,5.\n")
          .mesh;
  const Sum sum = of_sheets(mesh);
  Matrix3d Q;
  Q << 1, .3, 0, .3, 1, 0, 0, 0, .35;
  Q *= 7e10 / .91;
  EXPECT_LT((sum.A - 1e-3 * Q).norm(), 1e-12 * sum.A.norm());
  EXPECT_LT((sum.D - 300 * 1e-9 / 12 * Q).norm(), 1e-12 * sum.D.norm());
  EXPECT_NEAR(sum.mass, 2.7 + 5, 1e-12);
  // Shear force by strain: TS/T · T · G = 5/6 of the sheet's.
  double shear = 0;
  for (const ElementGroup& group : mesh.groups)
    shear += 5.0 / 6 * group.thickness *
             mesh.materials[static_cast<std::size_t>(group.material)].elastic.value()(4, 4);
  EXPECT_NEAR(shear, 10 * 1e-3 * 4e8, 1);
}

/// A cantilever whose moments of area change linearly between three stations: ends under a force, a moment, a
/// twist and a pull move by the integrals of the flexibility, ∫ (L − x)² dx / EI and so on.
TEST(NastranMesh, TaperedBeamsHaveTheFlexibilityOfTheirSections) {
  const double E = 7e10, G = 2.8e10, L = 2;
  struct Station {
    double x, area, I1, I2, J;
  };
  const std::vector<Station> stations{
      {0, 4e-3, 8e-6, 4e-6, 6e-6}, {1.2, 2e-3, 2e-6, 2e-6, 3e-6}, {L, 1.5e-3, 1e-6, 4e-7, 1e-6}};
  const SolidMesh mesh = parse(
                             "GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.\nMAT1,1,7.+10,2.8+10,,2700.\n"
                             "CBEAM,1,1,1,2,0.,1.,0.\n"
                             "PBEAM,1,1,4.-3,8.-6,4.-6,,6.-6,.5,\n,,,,,,,,,\n"
                             ",YESA,1.,1.5-3,1.-6,4.-7,,1.-6,.3,\n,NO,.6,2.-3,2.-6,2.-6,,3.-6,.5,\n,0.,0.\n")
                             .mesh;
  const FeMatrices matrices = assemble(mesh);
  const auto free = [&](const Eigen::MatrixXd& whole) {
    std::vector<Eigen::Index> rows;
    for (std::size_t k = 0; k < matrices.dofs.size(); ++k)
      if (matrices.dofs[k].node != 0) rows.push_back(static_cast<Eigen::Index>(k));
    return Eigen::MatrixXd(whole(rows, rows));
  };
  // The second node comes first behind the one that is held.
  ASSERT_EQ(matrices.dofs[6].node, 1);
  const Eigen::MatrixXd flexibility = inverse(free(test::full(matrices.stiffness)));
  const auto integral = [&](auto value) {
    double sum = 0;
    constexpr int steps = 20000;
    for (std::size_t k = 0; k + 1 < stations.size(); ++k) {
      const Station &a = stations[k], &b = stations[k + 1];
      for (int i = 0; i < steps; ++i) {
        const double t = (i + 0.5) / steps;
        const auto at = [&](double Station::*member) { return a.*member + t * (b.*member - a.*member); };
        sum += value(at) * (b.x - a.x) / steps;
      }
    }
    return sum;
  };
  const double stretch = integral([&](auto at) { return 1 / (E * at(&Station::area)); });
  const double twist = integral([&](auto at) { return 1 / (G * at(&Station::J)); });
  EXPECT_NEAR(flexibility(0, 0) / stretch, 1, 1e-7);
  EXPECT_NEAR(flexibility(3, 3) / twist, 1, 1e-7);
  for (const auto& [moved, turned, I] : {std::tuple(1, 5, &Station::I1), std::tuple(2, 4, &Station::I2)}) {
    const double turn = integral([&, I = I](auto at) { return 1 / (E * at(I)); });
    const double deflection = integral([&, I = I](auto at) {
      const double arm = L - at(&Station::x);
      return arm * arm / (E * at(I));
    });
    EXPECT_NEAR(flexibility(turned, turned) / turn, 1, 1e-7) << moved;
    EXPECT_NEAR(flexibility(moved, moved) / deflection, 1, 2e-3) << moved;
  }
  double mass = 0;
  const Eigen::MatrixXd M = test::full(matrices.mass);
  for (std::size_t a = 0; a < matrices.dofs.size(); ++a)
    for (std::size_t b = 0; b < matrices.dofs.size(); ++b)
      if (matrices.dofs[a].direction == 0 && matrices.dofs[b].direction == 0)
        mass += M(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
  EXPECT_NEAR(mass, 2700 * (1.2 * 3e-3 + 0.8 * 1.75e-3) + 1.2 * 0.5 + 0.8 * 0.4, 1e-9);
}

/// A bar that bends in one direction only, which is not one of its axes.
TEST(NastranMesh, BarsMayLackBendingStiffnessAlongAPrincipalAxis) {
  const std::string head =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nMAT1,1,7.+10,,.3,2700.\nCBAR,1,1,1,2,0.,1.,0.\n";
  const auto springs = [&](const char* property) { return parse(head + property).mesh.springs.size(); };
  // Stretch, twist, and two ways to bend.
  EXPECT_EQ(springs("PBAR,1,1,1.-3,1.-6,1.-6,1.-6,,,\n,,,,,,,,\n,,,1.-6\n"), 4u);
  EXPECT_EQ(springs("PBAR,1,1,1.-3,1.-6,,1.-6\n"), 4u);
}

/// The axis runs from centroid to centroid.
TEST(NastranMesh, TaperedBeamsFollowTheirNeutralAxis) {
  const SolidMesh mesh =
      parse(
          "GRID,1,,0.,0.,0.\nGRID,2,,2.,0.,0.\nMAT1,1,7.+10,2.8+10,,2700.\nCBEAM,1,1,1,2,0.,1.,0.\n"
          "PBEAM,1,1,4.-3,8.-6,4.-6,,6.-6,,\n,,,,,,,,,\n,NO,1.,2.-3,2.-6,2.-6,,3.-6,,\n"
          ",,,,,,,,,\n,,,,,.1,,.3,-.05\n")
          .mesh;
  ASSERT_GT(mesh.beams.size(), 2u);
  EXPECT_LT((mesh.beams.front().offsets[0] - Vector3d(0, 0.1, 0)).norm(), 1e-12);
  EXPECT_LT((mesh.beams.back().offsets[1] - Vector3d(0, 0.3, -0.05)).norm(), 1e-12);
  for (std::size_t k = 0; k + 1 < mesh.beams.size(); ++k) {
    const Vector3d inner = mesh.nodes.col(mesh.beams[k].nodes[1]);
    EXPECT_LT((inner - Vector3d(inner[0], 0.1 + 0.1 * inner[0], -0.025 * inner[0])).norm(), 1e-12);
    EXPECT_EQ(mesh.beams[k].nodes[1], mesh.beams[k + 1].nodes[0]);
  }
}

TEST(NastranMesh, BulkDataMayBeginTwiceInARow) {
  const std::string body =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\nCTETRA,1,1,1,2,3,4\nPSOLID,1,"
      "1\nMAT1,1,1.,,.3,1.\n";
  Folder folder;
  const auto read = [&](const std::string& begin) {
    return read_nastran(folder.write("deck.bdf", "SOL 101\nCEND\nBEGIN BULK\n" + begin + body));
  };
  EXPECT_EQ(read("\nBEGIN BULK  \n")->mesh.nodes.cols(), 4);
  for (const char* begin : {"BEGIN SUPER=1\n", "BEGIN BULK SUPER=1\n"})
    EXPECT_THAT(complaint([&] { read(begin); }),
                HasSubstr("deck.bdf:4:1: parts with bulk data of their own"));
}

/// Two nodes do not turn about their line, where the reference lies beside it.
TEST(NastranTies, MeansNeedNodesThatDetermineTheirMotion) {
  const std::string body =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\nCTETRA,1,1,1,2,3,4\nPSOLID,1,"
      "1\nMAT1,1,1.,,.3,1.\n";
  for (const char* mean :
       {"GRID,5,,.5,.1,0.\nRBE3,7,,5,123,1.,123,1,2\n", "GRID,5,,.5,0.,0.\nRBE3,7,,5,123456,1.,123,1,2\n"})
    EXPECT_THAT(complaint([&] { parse(body + mean); }),
                HasSubstr("deck.bdf:9:1: RBE3 7: its nodes do not determine a rigid motion"));
  EXPECT_EQ(parse(body + "GRID,5,,.5,0.,0.\nRBE3,7,,5,123,1.,123,1,2\n").mesh.mean_elements.size(), 1u);
  EXPECT_EQ(parse(body + "GRID,5,,.5,.1,0.\nRBE3,7,,5,123456,1.,123,1,2,,\n,3\n").mesh.mean_elements.size(),
            1u);
}

/// What only the reduction finds is named by its card and line, too.
TEST(NastranTies, AreNamedByTheirLineInTheReduction) {
  Folder folder;
  folder.write("ties.bdf", "$\nRBE2,8,1,123456,5\n");
  const auto read = read_nastran(folder.write(
      "deck.bdf",
      "SOL 101\nCEND\nMPC = 3\nBEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\n"
      "GRID,4,,0.,0.,1.\nGRID,5,,0.,0.,2.\nCTETRA,1,1,1,2,3,4\nPSOLID,1,1\nMAT1,1,1.,,.3,1.\n"
      "MPC,3,1,2,1.,4,2,-1.\nINCLUDE 'ties.bdf'\n"));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->mesh.equations.at(0).name, "MPC 3 of line 13");
  EXPECT_THAT(read->mesh.rigid_elements.at(0).name,
              AllOf(testing::StartsWith("RBE2 8 of "), testing::EndsWith("ties.bdf:2")));
}

TEST(NastranMesh, NamesAllThatItCannotTake) {
  Folder folder;
  folder.write("part.bdf", "CWELD,7,1\nCTRIA3,8,2,1,2,77\n");
  const std::string deck =
      folder.write("deck.bdf",
                   "SOL 101\nCEND\nMPC = 3\nBEGIN "
                   "BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,9,1.,1.,0.\n"
                   "INCLUDE "
                   "'part.bdf'\nCQUAD4,5,1,1,2,3,3x\nCBAR,6,4,1,2,0.,0.,1.\nCTRIA3,9,5,1,2,3\nPSHELL,5,6,."
                   "1\nFORCE,1,1,,1.,1.\n"
                   "CBEND,4\nNEWCARD,1\nENDDATA\n");
  const std::string all = complaint([&] { read_nastran(deck); });
  for (const char* part :
       {"part.bdf:1:1: CWELD 7: is not read, and the body would lack it",
        "part.bdf:2:1: element 8: property 2 is not there",
        "deck.bdf:8:1: GRID 4: coordinate system 9 is not there", "deck.bdf:10:1: CQUAD4 5: '3x' is no node",
        "deck.bdf:11:1: element 6: property 4 is not there",
        "deck.bdf:13:1: element 9: material 6 is not there", "deck.bdf:15:1: CBEND 4: is not read"})
    EXPECT_THAT(all, HasSubstr(part));
}

TEST(NastranMesh, SaysWhatItLeavesOut) {
  const std::string body =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\nCTETRA,1,1,1,2,3,4\nPSOLID,1,"
      "1\n"
      "MAT1,1,1.,,.3,1.\n";
  EXPECT_THAT(parse(body + "FORCE,1,1,,1.,1.\nTABLED1,2\n,0.,1.,ENDT\nPARAM,POST,-1\n").warnings, IsEmpty());
  const auto warned = [&](const std::string& more) {
    std::string all;
    for (const Diagnostic& one : parse(body + more).warnings) all += to_string(one) + "\n";
    return all;
  };
  EXPECT_THAT(warned("CELAS2,2,1.,1,1\n"), HasSubstr("deck.bdf:8:1: CELAS2 2: holds the body to the ground"));
  EXPECT_THAT(warned("CGAP,2,1,1,2\nCGAP,3,1,1,2\n"), HasSubstr("deck.bdf:8:1: gaps are left out"));
  EXPECT_THAT(warned("SPC,2,1,123\n"), HasSubstr("a body is free"));
  EXPECT_THAT(warned("NEWCARD,2\n"), HasSubstr("NEWCARD is not read"));
}

TEST(NastranMesh, ConstraintsOfGridsAreASet) {
  const ImportedMesh read = parse(
      "GRID,1,,0.,0.,0.,,123\nGRID,2,,1.,0.,0.,,0\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.,,456\n"
      "CTETRA,1,1,1,2,3,4\nPSOLID,1,1\nMAT1,1,1.,,.3,1.\n");
  ASSERT_EQ(read.mesh.node_sets.front().name, "GRID:PS");
  EXPECT_THAT(read.mesh.node_sets.front().nodes, ElementsAre(0, 3));
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_THAT(to_string(read.warnings[0]), HasSubstr("deck.bdf:1:1: constraints of GRID (PS)"));
}

/// Free field goes on behind blanks and a comma, and replication counts up from a blank field as from zero.
TEST(NastranMesh, FreeFieldIsReadAsPeopleWriteIt) {
  const SolidMesh mesh =
      parse(
          "CORD2R,1,,0.,0.,0.,0.,0.,1.,\n      , 1., 0., 0.\nGRID,1,1,0.,0.,0.\n=,*(1),=,*(1.),=,=,*(1)\n"
          "GRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\nCTETRA,1,1,1,2,3,4\nPSOLID,1,1\nMAT1,1,1.,,.3,1.\n")
          .mesh;
  EXPECT_EQ(mesh.labels[1], 2);
  EXPECT_LT((mesh.nodes.col(1) - Vector3d(1, 0, 0)).norm(), 1e-15);
}

/// Parts that share nodes may each bring them.
TEST(NastranMesh, TheSameGridMayStandTwice) {
  const std::string body =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n"
      "CTETRA,1,1,1,2,3,4\nPSOLID,1,1\nMAT1,1,1.,,.3,1.\n";
  EXPECT_THAT(parse(body + "GRID,2,,1.,0.,0.\n").mesh.labels, ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(complaint([&] { parse(body + "GRID,2,,1.,.1,0.\n"); }),
              HasSubstr("deck.bdf:8:1: GRID 2: is there already, at another place"));
}

/// A line that goes on another card than the one before would give that one its fields.
TEST(NastranMesh, LinesGoOnWithTheCardBefore) {
  const auto wrong = [](const std::string& first, const std::string& second) {
    return complaint([&] {
      parse(
          "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nGRID,5,,0.,0.,1.\n"
          "GRID,6,,1.,0.,1.\nGRID,7,,1.,1.,1.\nGRID,8,,0.,1.,1.\nPSOLID,1,1\nMAT1,1,1.,,.3,1.\n"
          "CHEXA   1       1       1       2       3       4       5       6       " +
          first + "\n" + second + "7       8\n");
    });
  };
  for (const auto& [first, second] :
       {std::pair("+A", "+a      "), std::pair("+A", "+       "), std::pair("+", "+B      "),
        std::pair("BRICK", "+B      "), std::pair("", "        ")})
    EXPECT_EQ(wrong(first, second), "") << first;
  EXPECT_THAT(wrong("+A", "+B      "),
              HasSubstr("deck.bdf:12:1: goes on with 'B' where the line before names 'A'"));
}

TEST(NastranMesh, WithoutElementsIsNone) {
  Folder folder;
  EXPECT_FALSE(read_nastran(folder.write("a.bdf", "DMIG,KAAX,0,6,1\nGRID,1\n")));
  EXPECT_THAT(complaint([&] { read_nastran(folder.write("b.bdf", "GRID,1\n")); }),
              HasSubstr("has neither elements nor DMIG matrices"));
  EXPECT_THAT(complaint([&] { read_nastran(folder.write("c.bdf", "INCLUDE 'c.bdf'\n")); }),
              HasSubstr("includes itself"));
  EXPECT_THAT(complaint([&] { read_nastran(folder.write("c.bdf", "INCLUDE 'd.bdf'\n")); }),
              HasSubstr("is not there"));
}

}  // namespace
}  // namespace mimbre::fe::nastran_mesh_test
