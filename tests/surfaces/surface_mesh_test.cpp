#include "mimbre/surface_mesh.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "mimbre/model.h"
#include "mimbre/model_file.h"
#include "simulation/describe/body_drawings.h"

namespace mimbre::surface_mesh_test {
namespace {

namespace fs = std::filesystem;

std::string sample(const std::string& name) { return MIMBRE_SOURCE_DIR "/tests/data/surfaces/" + name; }

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A file that is gone with the test.
struct Scratch {
  std::string path;
  Scratch(const std::string& name, const std::string& bytes)
      : path((fs::path(testing::TempDir()) / name).string()) {
    std::ofstream(path, std::ios::binary) << bytes;
  }
  ~Scratch() { fs::remove(path); }
};

std::string refusal(const std::string& path) {
  try {
    read_surface_mesh(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

class SurfaceFormats : public testing::TestWithParam<const char*> {};

/// One block of 1 × 2 × 3 in each format, with the origin at a corner.
TEST_P(SurfaceFormats, GiveTheSameClosedBlock) {
  const SurfaceMesh mesh = read_surface_mesh(sample(GetParam()));
  ASSERT_EQ(mesh.vertices.cols(), 8);
  ASSERT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(why_not_closed(mesh), "");
  EXPECT_NEAR(enclosed_volume(mesh), 6, 1e-6);
  EXPECT_LT((mesh.vertices.rowwise().minCoeff() - Eigen::Vector3d(0, 0, 0)).norm(), 1e-6);
  EXPECT_LT((mesh.vertices.rowwise().maxCoeff() - Eigen::Vector3d(1, 2, 3)).norm(), 1e-6);
}
INSTANTIATE_TEST_SUITE_P(Files, SurfaceFormats,
                         testing::Values("block.stl", "block-text.stl", "block.obj", "block.ply", "block.glb",
                                         "block.gltf", "block.dae"),
                         [](const auto& format) {
                           std::string name = format.param;
                           for (char& c : name)
                             if (c == '.' || c == '-') c = '_';
                           return name;
                         });

TEST(SurfaceMesh, VolumeDoesNotDependOnThePlaceOfTheOrigin) {
  SurfaceMesh mesh = read_surface_mesh(sample("block.stl"));
  mesh.vertices.colwise() += Eigen::Vector3d(1e5, -2e5, 3e5);
  EXPECT_NEAR(enclosed_volume(mesh), 6, 1e-9);
}

TEST(SurfaceMesh, SaysWhatKeepsASurfaceFromBeingClosed) {
  const SurfaceMesh block = read_surface_mesh(sample("block.stl"));
  SurfaceMesh mesh = block;
  mesh.triangles.pop_back();
  EXPECT_THAT(why_not_closed(mesh), testing::HasSubstr("3 of its edges belong to one triangle only"));
  mesh = block;
  mesh.triangles.push_back(mesh.triangles.front());
  EXPECT_THAT(why_not_closed(mesh), testing::HasSubstr("more than two triangles"));
  mesh = block;
  std::swap(mesh.triangles[5][0], mesh.triangles[5][1]);
  EXPECT_THAT(why_not_closed(mesh), testing::HasSubstr("at 3 of its edges one triangle faces outwards"));
  for (auto& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  std::swap(mesh.triangles[5][0], mesh.triangles[5][1]);
  EXPECT_THAT(why_not_closed(mesh), testing::HasSubstr("face inwards"));
  EXPECT_NEAR(enclosed_volume(mesh), -6, 1e-9);
  mesh.triangles.clear();
  EXPECT_EQ(why_not_closed(mesh), "it has no triangles");
}

TEST(SurfaceMesh, RefusesWhatIsNoSurface) {
  EXPECT_THAT(refusal(sample("none.stl")), testing::HasSubstr("none.stl: there is no such file"));
  EXPECT_THAT(refusal(MIMBRE_SOURCE_DIR "/README.md"), testing::HasSubstr("must be one of .stl, .obj"));
  EXPECT_NE(refusal(Scratch("empty.stl", "").path), "");
  EXPECT_THAT(refusal(Scratch("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n").path),
              testing::HasSubstr("points.obj"));
  EXPECT_THAT(refusal(Scratch("flat.obj", "v 0 0 0\nv 0 0 0\nv 0 1 0\nf 1 2 3\n").path),
              testing::HasSubstr("no triangle with an area"));
  EXPECT_THAT(refusal(Scratch("far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4000000000\n").path),
              testing::HasSubstr("far.obj"));
}

TEST(SurfaceMesh, RefusesDamagedFiles) {
  const std::string whole = bytes_of(sample("block.stl"));
  std::string bytes = whole;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(bytes.data() + 100, &nan, sizeof nan);
  EXPECT_THAT(refusal(Scratch("nan.stl", bytes).path), testing::HasSubstr("not finite"));
  bytes = whole;
  const std::uint32_t huge = 0xffffffff;
  std::memcpy(bytes.data() + 80, &huge, sizeof huge);
  EXPECT_THAT(refusal(Scratch("huge.stl", bytes).path),
              testing::HasSubstr("huge.stl: cannot be read as a surface"));
  for (const std::size_t length : {1, 40, 83, 84, 100, 300, 683})
    EXPECT_NE(refusal(Scratch("short.stl", whole.substr(0, length)).path), "") << length;
  const std::string scene = bytes_of(sample("block.glb"));
  for (std::size_t length = 0; length < scene.size(); length += 61)
    EXPECT_NE(refusal(Scratch("short.glb", scene.substr(0, length)).path), "") << length;
}

constexpr const char* two_doors = R"(mimbre: 1
subsystems:
  side:
    bodies:
      door:
        mass: 1
        com: [0.5, 1, 0]
        inertia: [1, 1, 1]
        shapes:
          - {mesh: block.stl, at: [0, 3, 0], x: [0, 1, 0], y: [-1, 0, 0], scale: [1, 0.5, 2]}
          - {sphere: 0.1}
instances:
  left: {of: side}
  right: {of: side, mirror: y, rotate: [0, 0, 90 deg], at: [1, 0, 0]}
)";

/// A mirrored instance draws the mirror image, with its triangles still counterclockwise from outside.
TEST(SurfaceMesh, IsDrawnWhereAPartStands) {
  const spec::Model model = parse_model(two_doors, "doors.yaml", MIMBRE_SOURCE_DIR "/tests/data/surfaces");
  const auto drawings = body_drawings(model);
  ASSERT_EQ(drawings.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    const BodyDrawing& drawing = drawings[k];
    ASSERT_EQ(drawing.shapes.size(), 1u);
    ASSERT_EQ(drawing.points.cols(), 8);
    ASSERT_EQ(drawing.triangles.size(), 12u);
    const SurfaceMesh drawn{drawing.points, drawing.triangles};
    EXPECT_EQ(why_not_closed(drawn), "") << k;
    EXPECT_NEAR(enclosed_volume(drawn), 6, 1e-6);
    const spec::Pose& pose = model.bodies[k].pose;
    const Eigen::Matrix3Xd global = (pose.rotation * drawing.points).colwise() + pose.position;
    // left: x' = −s_y y, y' = 3 + x, z' = 2 z of the file; right: of that y mirrored, turned by 90° and moved
    const Eigen::Vector3d low = k == 0 ? Eigen::Vector3d(-1, 3, 0) : Eigen::Vector3d(4, -1, 0);
    const Eigen::Vector3d high = k == 0 ? Eigen::Vector3d(0, 4, 6) : Eigen::Vector3d(5, 0, 6);
    EXPECT_LT((global.rowwise().minCoeff() - low).norm(), 1e-6) << k;
    EXPECT_LT((global.rowwise().maxCoeff() - high).norm(), 1e-6) << k;
  }
}

std::string model_refusal(const std::string& shape) {
  const std::string text = fmt::format(
      "mimbre: 1\nbodies:\n  door:\n    mass: 1\n    com: [0, 0, 0]\n    inertia: [1, 1, 1]\n    shapes: "
      "[{{{}}}]\n",
      shape);
  try {
    parse_model(text, "door.yaml", MIMBRE_SOURCE_DIR "/tests/data/surfaces");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SurfaceMesh, MistakesInModelFilesAreToldWhereTheyAre) {
  EXPECT_EQ(model_refusal("mesh: block.stl"), "");
  EXPECT_THAT(model_refusal("mesh: blok.stl"),
              testing::AllOf(testing::HasSubstr("door.yaml:7:"),
                             testing::HasSubstr("blok.stl: there is no such file")));
  EXPECT_THAT(model_refusal("mesh: block.stl, scale: 0"), testing::HasSubstr("scale: 0.001"));
  EXPECT_THAT(model_refusal("sphere: 1, scale: 2"), testing::HasSubstr("'scale' is for a mesh"));
  EXPECT_THAT(model_refusal("mesh: block.stl, axis: [0, 0, 1]"),
              testing::HasSubstr("'axis' is for cylinders"));
}

/// A file of 262 bytes whose polygons lead its importer astray for seconds, and ones that end early.
TEST(SurfaceFile, OfPolygonsHoldsWhatItsHeaderSays) {
  EXPECT_THAT(refusal(sample("short.ply")), testing::HasSubstr("is damaged: its header has no end"));
  const auto polygons = [](const std::string& rest) {
    return refusal(Scratch("polygons.ply",
                           "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty "
                           "float y\nproperty float z\nelement face 1\nproperty list uchar int "
                           "vertex_indices\nend_header\n" +
                               rest)
                       .path);
  };
  EXPECT_EQ(polygons("0 0 0\n1 0 0\n\n0 1 0\n3 0 1 2\n"), "");
  EXPECT_THAT(polygons("0 0 {}\n1 0 0\n0 1 0\n3 0 1 2\n"),
              testing::HasSubstr("'{}' in line 10 is no number"));
  EXPECT_THAT(polygons("0 0 0\n1 0 0\n"),
              testing::HasSubstr("names 3 times 'vertex', and the file ends in the 3."));
  EXPECT_THAT(polygons("0 0 0\n1 0 0\n0 1 0\n51 3 2\n"), testing::HasSubstr("ends in the 1. of them"));
  EXPECT_THAT(polygons("0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n"), testing::HasSubstr("a list of 'face' has -3"));
}

}  // namespace
}  // namespace mimbre::surface_mesh_test
