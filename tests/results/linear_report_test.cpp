#include "mimbre/linear_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <complex>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "base/hdf5.h"
#include "math/rotation.h"
#include "mimbre/diagnostics.h"
#include "mimbre/report.h"
#include "mimbre/usage_error.h"
#include "support/models.h"
#include "support/report_data.h"

/// Pages and files of modes and of linear models.
namespace mimbre::linear_report_test {
namespace {

namespace fs = std::filesystem;
using report_data::data_text;
using report_data::decoded;
using report_data::Json;
using testing::HasSubstr;
using Doubles = std::vector<double>;

class LinearReport : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::path(testing::TempDir()) / ("mimbre-linear-report-" + std::to_string(getpid()));
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }
  fs::path folder;
};

/// A slide on a spring that carries a pendulum with a box, and a damper that turns.
std::shared_ptr<const Model> slide() {
  return test::model_of(R"yaml(
gravity: [0, 0, -9.81]
bodies:
  slide: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1], shapes: [{box: [0.2, 0.2, 0.2]}]}
  bob:
    mass: 1
    com: [0, 0, -1]
    inertia: [0.01, 0.01, 0.01]
    shapes: [{sphere: 0.1, at: [0, 0, -1]}, {cylinder: [0.02, 1], at: [0, 0, -0.5]}]
joints:
  rail: {type: prismatic, between: [ground, slide], at: [0, 0, 0], axis: [1, 0, 0],
         spring: {stiffness: 30, damping: 0.5}}
  pin: {type: revolute, between: [slide, bob], at: [0, 0, 0], axis: [0, 1, 0]}
inputs: {push: {start: 0, unit: N}}
actuators: {motor: {joint: rail, force: push}}
outputs: [{name: way, joint: rail}, {name: angle, joint: pin}]
)yaml");
}

LinearisedModes modes_of(const std::shared_ptr<const Model>& model,
                         LinearPoint::At at = LinearPoint::At::automatic) {
  ModesOptions options;
  options.linear.point.at = at;
  options.shapes = true;
  return find_modes(model, options);
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

Doubles numbers(const hdf5::Handle& file, const char* name, std::vector<hsize_t> shape) {
  const hdf5::Handle data = hdf5::open_dataset(file.get(), name);
  EXPECT_TRUE(data.valid()) << name;
  if (!data.valid()) return {};
  const hdf5::Handle space(H5Dget_space(data.get()));
  std::vector<hsize_t> is(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space.get())));
  H5Sget_simple_extent_dims(space.get(), is.data(), nullptr);
  EXPECT_EQ(is, shape) << name;
  Doubles values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())));
  H5Dread(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  return values;
}

TEST_F(LinearReport, Hdf5HasTheModesByCoordinateAndByBody) {
  const LinearisedModes found = modes_of(test::example("rotor/two-discs.yaml"), LinearPoint::At::steady);
  const MechanismShapes& shapes = *found.shapes;
  const std::string path = (folder / "shapes.h5").string();
  write_modes(found, path);
  const hdf5::Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  ASSERT_TRUE(file.valid());
  const hsize_t m = found.modes.size(), b = shapes.header.bodies.size(), c = found.coordinates.size(),
                a = static_cast<hsize_t>(shapes.at.modes.size());
  EXPECT_EQ(numbers(file, "frequency", {m})[2], found.modes[2].frequency);
  EXPECT_EQ(numbers(file, "value_imaginary", {m})[3], found.modes[3].value.imag());
  EXPECT_EQ(numbers(file, "from_ground_imaginary", {m})[3], found.modes[3].fixed.imag());
  const Doubles shape = numbers(file, "shape_imaginary", {m, c});
  EXPECT_EQ(shape[4 * c + 1], found.modes[4].motion[1].imag());
  const Doubles moved = numbers(file, "displacement_real", {m, b, 3}),
                turned = numbers(file, "turn_imaginary", {m, b, 3}),
                bent = numbers(file, "mode_amplitudes_real", {m, a});
  for (hsize_t k = 0; k < m; ++k) {
    const BodyShapes& mode = shapes.modes[k];
    for (hsize_t i = 0; i < b; ++i)
      for (hsize_t axis = 0; axis < 3; ++axis) {
        const auto row = static_cast<Eigen::Index>(axis), column = static_cast<Eigen::Index>(i);
        EXPECT_EQ(moved[(k * b + i) * 3 + axis], mode.displacement(row, column).real());
        EXPECT_EQ(turned[(k * b + i) * 3 + axis], mode.turn(row, column).imag());
      }
    for (hsize_t i = 0; i < a; ++i)
      EXPECT_EQ(bent[k * a + i], mode.amplitudes[static_cast<Eigen::Index>(i)].real());
  }
  EXPECT_EQ(numbers(file, "positions", {b, 3})[1], shapes.at.poses(1, 0));
  EXPECT_EQ(numbers(file, "quaternions", {b, 4})[0], shapes.at.poses(3, 0));
  EXPECT_EQ(numbers(file, "amplitude_body", {a}).size(), a);
  // Identical modes give identical bytes.
  const std::string again = (folder / "again.h5").string();
  write_modes(found, again);
  EXPECT_EQ(text_of(path).size(), text_of(again).size());
}

TEST_F(LinearReport, ModesWithoutShapesAreAMistakeOfTheProgram) {
  EXPECT_THROW(write_modes(find_modes(slide()), (folder / "x.h5").string()), std::invalid_argument);
  EXPECT_THROW(write_modes_vtk(find_modes(slide()), (folder / "x").string()), std::invalid_argument);
}

TEST_F(LinearReport, UnknownEndingsNameTheKnownOnes) {
  const auto message = [](const auto& work) -> std::string {
    try {
      work();
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message([] { check_modes_path("modes.csv"); }), HasSubstr(".html or .h5"));
  EXPECT_THAT(message([] { check_linear_path("model.csv", {}); }), HasSubstr(".html, .h5, .mat or .json"));
  EXPECT_THAT(message([] { check_linear_path("bode.html", {}); }), HasSubstr("--frequencies"));
}

/// The data array of that name in a VTK file.
std::vector<float> vtk_floats(const std::string& file, const std::string& name) {
  const auto at = file.find("Name=\"" + name + "\"");
  if (at == std::string::npos) return {};
  const auto begin = file.find('>', at) + 1;
  const auto bytes = report_data::from_base64(file.substr(begin, file.find('<', begin) - begin));
  std::vector<float> values((bytes.size() - sizeof(std::uint64_t)) / sizeof(float));
  std::memcpy(values.data(), bytes.data() + sizeof(std::uint64_t), values.size() * sizeof(float));
  return values;
}

TEST_F(LinearReport, VtkHasEachModeOverAPeriod) {
  const LinearisedModes found = modes_of(slide());
  ASSERT_EQ(found.modes.size(), 2u);
  const MechanismShapes& shapes = *found.shapes;
  ModesVtkOptions options;
  options.frames = 8;
  options.share = 1e-3;
  std::ofstream(folder / "mode_notes.pvd") << "kept";
  std::ofstream(folder / "old.vtp") << "replaced";
  EXPECT_EQ(write_modes_vtk(found, folder.string(), options), (folder / "mode_1.pvd").string());
  EXPECT_TRUE(fs::exists(folder / "mode_notes.pvd"));
  EXPECT_FALSE(fs::exists(folder / "old.vtp"));
  const std::string series = text_of(folder / "mode_2.pvd");
  const double period = 2 * std::numbers::pi / found.modes[1].value.imag();
  EXPECT_THAT(series, HasSubstr("<!-- "));
  EXPECT_THAT(series, HasSubstr("file=\"mode_2_007.vtp\""));
  std::ostringstream half;
  EXPECT_NE(series.find("timestep=\"0\""), std::string::npos);
  EXPECT_NEAR(std::stod(series.substr(series.find("timestep", series.find("mode_2_000")) + 10)), period / 8,
              1e-9);
  // The box's corner: q + A Re(x e^{iφ}) to the second order of A.
  const double factor = drawing_factor(shapes, 1, options.share);
  for (int f = 0; f < 8; ++f) {
    const std::string file = text_of(folder / ("mode_2_00" + std::to_string(f) + ".vtp"));
    const std::vector<float> points = vtk_floats(file, "points"), moved = vtk_floats(file, "displacement");
    ASSERT_EQ(points.size(), moved.size());
    const std::complex<double> turned = std::polar(factor, 2 * std::numbers::pi * f / 8);
    double most = 0;
    std::size_t p = 0;
    // The slide's box comes first, the bob's sphere and rod last.
    for (; p < points.size() / 3; ++p) {
      const Eigen::Index body = p < 18 ? 0 : 1;
      const Eigen::Vector3d u(moved[3 * p], moved[3 * p + 1], moved[3 * p + 2]),
          at = Eigen::Vector3d(points[3 * p], points[3 * p + 1], points[3 * p + 2]) - u,
          lever = at - shapes.at.poses.col(body).head<3>(),
          turn = (turned * shapes.modes[1].turn.col(body)).real(),
          wanted = (turned * shapes.modes[1].displacement.col(body)).real() + turn.cross(lever);
      EXPECT_LT((u - wanted).norm(), 1e-5 * shapes.size) << p;
      most = std::max(most, u.norm());
    }
    EXPECT_LT(most, 1.01e-3 * shapes.size);
  }
}

TEST_F(LinearReport, PageHasTheSceneAndTheShapes) {
  if (!report_available()) GTEST_SKIP() << "built without the report page";
  const LinearisedModes found = modes_of(slide());
  const Json data = Json::parse(data_text(mode_shapes_html(found)));
  EXPECT_EQ(data["format"], "mimbre-mechanism-modes-1");
  EXPECT_EQ(data["title"], found.shapes->header.title);
  EXPECT_EQ(data["bodies"].size(), 2u);
  EXPECT_EQ(data["modes"].size(), found.modes.size());
  EXPECT_EQ(data["modes"][1]["text"], found.modes[1].text);
  const auto shapes = decoded<float>(data["shapes"]);
  ASSERT_EQ(shapes.size(), found.modes.size() * 2 * 12);
  // Of the second mode the second body: turn, real part, about y.
  EXPECT_NEAR(shapes[(1 * 2 + 1) * 12 + 6 + 1], found.shapes->modes[1].turn(1, 1).real(), 1e-6);
  EXPECT_EQ(decoded<double>(data["animation"]["time"]).size(), 1u);
  write_modes(found, (folder / "modes.html").string());
  EXPECT_EQ(text_of(folder / "modes.html"), mode_shapes_html(found));
}

TEST_F(LinearReport, BodePageHasTheResponses) {
  if (!report_available()) GTEST_SKIP() << "built without the report page";
  const LinearModel model = linearise(slide());
  const std::vector<double> frequencies{0.1, 1, 10};
  const Json data = Json::parse(data_text(bode_html(model, frequencies)));
  EXPECT_EQ(data["format"], "mimbre-bode-1");
  EXPECT_EQ(data["inputs"][0]["name"], "push");
  EXPECT_EQ(data["outputs"][1]["name"], "angle");
  const auto real = decoded<double>(data["real"]), imaginary = decoded<double>(data["imaginary"]);
  ASSERT_EQ(real.size(), 6u);
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::MatrixXcd response = frequency_response(model, 2 * std::numbers::pi * frequencies[k]);
    EXPECT_NEAR(real[3 + k], response(1, 0).real(), 1e-12);
    EXPECT_NEAR(imaginary[k], response(0, 0).imag(), 1e-12);
  }
  write_linear_file(model, (folder / "bode.html").string(), frequencies);
  EXPECT_TRUE(fs::exists(folder / "bode.html"));
}

TEST_F(LinearReport, BodePageNeedsInputsAndOutputs) {
  LinearModel model = linearise(slide());
  const auto message = [&](const LinearModel& m) -> std::string {
    try {
      bode_html(m, {1, 2});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  LinearModel without = model;
  without.outputs.clear();
  EXPECT_THAT(message(without), HasSubstr("no outputs"));
  without = model;
  without.inputs.clear();
  EXPECT_THAT(message(without), HasSubstr("no inputs"));
}

}  // namespace
}  // namespace mimbre::linear_report_test
