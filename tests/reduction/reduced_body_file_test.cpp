#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "fe/meshes.h"
#include "mimbre/diagnostics.h"
#include "mimbre/reduced_body.h"

namespace mimbre::test::reduced_body_file_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

ReducedBody some_body(fe::Stiffening stiffening = fe::Stiffening::linear) {
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.boundary = {{2, false, Eigen::Vector3d::UnitZ(), "tip.z"}};
  options.dynamic_modes = 3;
  options.stiffness_damping = 0.02;
  options.stiffening = stiffening;
  ReducedBody body = fe::reduce(bent_frame(), options,
                                {{"tip", 2, some_rotation()}, {"gelenk ä", 1, Eigen::Matrix3d::Identity()}});
  body.name = "bent frame";
  return body;
}

class ReducedBodyFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("mimbre_reduced_body_") + info->name() + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name = "body.h5") const { return (folder_ / name).string(); }

  static std::string bytes(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static void write(const std::string& path, const std::string& content) {
    std::ofstream(path, std::ios::binary) << content;
  }

  std::string saving(const ReducedBody& body) const {
    try {
      save(body, path());
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  static std::string load_error(const std::string& path) {
    try {
      load_reduced_body(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  /// What loading says after `change` was applied to a good file.
  template <typename Change>
  std::string error_after(Change change) const {
    save(some_body(), path());
    const hid_t file = H5Fopen(path().c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    change(file);
    H5Fclose(file);
    return load_error(path());
  }

  static void replace_dataset(hid_t file, const char* name, std::vector<hsize_t> shape, double value) {
    H5Ldelete(file, name, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
    const hid_t set = H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    hsize_t count = 1;
    for (hsize_t extent : shape) count *= extent;
    if (count < 1000) {
      const std::vector<double> data(count, value);
      H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data());
    }
    H5Dclose(set);
    H5Sclose(space);
  }

 private:
  std::filesystem::path folder_;
};

TEST_F(ReducedBodyFile, GivesGeometricStiffnessBack) {
  const ReducedBody body = some_body(fe::Stiffening::geometric_stiffness);
  ASSERT_TRUE(body.geometric);
  ASSERT_GT(body.geometric->loads.size(), 10u);
  ASSERT_EQ(body.geometric->boundary_loads.rows(), 1);
  save(body, path());
  const ReducedBody read = load_reduced_body(path());
  ASSERT_TRUE(read.geometric);
  EXPECT_EQ(read.geometric->loads, body.geometric->loads);
  EXPECT_EQ(read.geometric->stiffness, body.geometric->stiffness);
  EXPECT_EQ(read.geometric->boundary_loads, body.geometric->boundary_loads);
  EXPECT_FALSE(read.second_order);
}

/// What bending stretches, of a body with two places; a file without it is a body without it.
TEST_F(ReducedBodyFile, GivesStretchingBack) {
  const ReducedBody body = some_body();
  ASSERT_TRUE(body.stretching);
  ASSERT_FALSE(body.stretching->forms.empty());
  save(body, path());
  const ReducedBody read = load_reduced_body(path());
  ASSERT_TRUE(read.stretching);
  EXPECT_EQ(read.stretching->forms, body.stretching->forms);
  EXPECT_EQ(read.stretching->places, body.stretching->places);
  EXPECT_EQ(read.stretching->stiffness, body.stretching->stiffness);
  EXPECT_EQ(read.stretching->place_of_frame, body.stretching->place_of_frame);
  ReducedBody other = body;
  other.stretching.reset();
  save(other, path());
  EXPECT_FALSE(load_reduced_body(path()).stretching);
}

TEST_F(ReducedBodyFile, SaysWhatIsWrongWithStretching) {
  const ReducedBody good = some_body();
  ReducedBody body = good;
  body.stretching->place_of_frame.back() = 7;
  EXPECT_THAT(saving(body), HasSubstr("there is no place 7"));
  body = good;
  body.stretching->place_of_frame.pop_back();
  EXPECT_THAT(saving(body), HasSubstr("place_of_frame must be 2, are 1"));
  body = good;
  body.stretching->forms.front()(0, 1) += 1;
  EXPECT_THAT(saving(body), HasSubstr("stretching: forms must be symmetric"));
  body = good;
  body.stretching->forms.front().resize(2, 2);
  EXPECT_THAT(saving(body), HasSubstr("stretching: forms"));
  body = good;
  while (body.stretching->forms.size() < 9) body.stretching->forms.push_back(good.stretching->forms.front());
  body.stretching->places.setZero(9, good.stretching->places.cols());
  EXPECT_THAT(saving(body), HasSubstr("at most 8 forms, there are 9"));
}

TEST_F(ReducedBodyFile, GivesTurningAndCertificateBack) {
  ReducedBody body = some_body();
  for (const auto turning :
       {BoundaryRotation::exponential, BoundaryRotation::successive, BoundaryRotation::infinitesimal}) {
    body.boundary_rotation = turning;
    body.checks = {{"units", true, "1 m long"}, {"mass", false, ""}};
    save(body, path());
    const ReducedBody read = load_reduced_body(path());
    EXPECT_EQ(read.boundary_rotation, turning);
    ASSERT_EQ(read.checks.size(), 2u);
    EXPECT_EQ(read.checks[0].detail, "1 m long");
    EXPECT_TRUE(read.checks[0].passed);
    EXPECT_FALSE(read.checks[1].passed);
  }
}

TEST_F(ReducedBodyFile, GivesLargeDeflectionsBack) {
  const ReducedBody body = some_body(fe::Stiffening::foreshortening);
  ASSERT_TRUE(body.second_order);
  save(body, path());
  const ReducedBody read = load_reduced_body(path());
  ASSERT_TRUE(read.second_order);
  const SecondOrder &a = *body.second_order, &b = *read.second_order;
  EXPECT_EQ(b.products, a.products);
  EXPECT_EQ(b.S, a.S);
  EXPECT_EQ(b.S_position, a.S_position);
  EXPECT_EQ(b.S_modes, a.S_modes);
  EXPECT_EQ(b.mass_matrix, a.mass_matrix);
  EXPECT_EQ(b.stiffness, a.stiffness);
  EXPECT_EQ(b.frame_shapes, a.frame_shapes);
  EXPECT_EQ(b.node_shapes, a.node_shapes);
  EXPECT_EQ(b.mesh_shapes, a.mesh_shapes);
  EXPECT_FALSE(read.geometric);
}

TEST_F(ReducedBodyFile, SaysWhatIsWrongWithStiffening) {
  ReducedBody body = some_body(fe::Stiffening::geometric_stiffness);
  const ReducedBody good = body;
  body.geometric->loads.back() = 13;
  EXPECT_THAT(saving(body), HasSubstr("geometric stiffness: load 13 must be from 0 to 12"));
  body = good;
  std::swap(body.geometric->loads[0], body.geometric->loads[1]);
  EXPECT_THAT(saving(body), HasSubstr("loads must ascend"));
  body = good;
  body.geometric->stiffness[2](0, 1) += 1;
  EXPECT_THAT(saving(body), HasSubstr("geometric stiffness must be symmetric"));
  body = good;
  body.geometric->stiffness.pop_back();
  EXPECT_THAT(saving(body), HasSubstr("one matrix for each"));
  body = some_body(fe::Stiffening::foreshortening);
  body.geometric = good.geometric;
  EXPECT_THAT(saving(body), HasSubstr("must not have it too"));
  body.geometric.reset();
  body.second_order->products.front() = {1, 0};
  EXPECT_THAT(saving(body), HasSubstr("product (1, 0)"));
}

TEST_F(ReducedBodyFile, GivesBackWhatWasSavedToTheLastBit) {
  const ReducedBody body = some_body();
  save(body, path());
  const ReducedBody read = load_reduced_body(path());
  EXPECT_EQ(read.name, body.name);
  EXPECT_EQ(read.modes, body.modes);
  EXPECT_EQ(read.mode_names, body.mode_names);
  EXPECT_EQ(read.mass, body.mass);
  EXPECT_EQ(read.first_moment, body.first_moment);
  EXPECT_EQ(read.second_moment, body.second_moment);
  EXPECT_EQ(read.S, body.S);
  EXPECT_EQ(read.S_position, body.S_position);
  EXPECT_EQ(read.S_modes, body.S_modes);
  EXPECT_EQ(read.mass_matrix, body.mass_matrix);
  EXPECT_EQ(read.stiffness, body.stiffness);
  EXPECT_EQ(read.damping, body.damping);
  EXPECT_EQ(read.user_from_modal, body.user_from_modal);
  EXPECT_EQ(read.eigenfrequencies, body.eigenfrequencies);
  EXPECT_EQ(read.nodes, body.nodes);
  EXPECT_EQ(read.node_shapes, body.node_shapes);
  EXPECT_EQ(read.lines, body.lines);
  EXPECT_EQ(read.line_radius, body.line_radius);
  ASSERT_TRUE(read.mesh_inertia);
  EXPECT_EQ(read.mesh_inertia->dofs_per_node, 6);
  EXPECT_EQ(read.mesh_inertia->shapes, body.mesh_inertia->shapes);
  const auto dense = [](const Eigen::SparseMatrix<double>& m) { return Eigen::MatrixXd(m); };
  EXPECT_EQ(dense(read.mesh_inertia->mass), dense(body.mesh_inertia->mass));
  EXPECT_EQ(read.mesh_inertia->mass.nonZeros(), body.mesh_inertia->mass.nonZeros());
  EXPECT_EQ(dense(read.mesh_inertia->nodal_mass), dense(body.mesh_inertia->nodal_mass));
  ASSERT_EQ(read.frames.size(), body.frames.size());
  for (std::size_t k = 0; k < body.frames.size(); ++k) {
    EXPECT_EQ(read.frames[k].name, body.frames[k].name);
    EXPECT_EQ(read.frames[k].position, body.frames[k].position);
    EXPECT_EQ(read.frames[k].rotation, body.frames[k].rotation);
    EXPECT_EQ(read.frames[k].X, body.frames[k].X);
    EXPECT_EQ(read.frames[k].X_theta, body.frames[k].X_theta);
  }
}

TEST_F(ReducedBodyFile, GivesTheSurfaceAndItsStressBack) {
  ReducedBody body = some_body();
  const Eigen::Index nodes = body.nodes.cols();
  ASSERT_GE(nodes, 3);
  body.triangles = {{0, 1, 2}, {2, 1, 0}};
  for (Eigen::Index k = 0; k < nodes; ++k) body.node_labels.push_back(5'000'000'000 + k);
  body.stress = 1e9 * Eigen::MatrixXd::Random(6 * nodes, body.modes);
  body.strain = Eigen::MatrixXd::Random(6 * nodes, body.modes);
  save(body, path());
  const ReducedBody read = load_reduced_body(path());
  EXPECT_EQ(read.triangles, body.triangles);
  EXPECT_EQ(read.node_labels, body.node_labels);
  EXPECT_EQ(read.stress, body.stress);
  EXPECT_EQ(read.strain, body.strain);
  EXPECT_TRUE(check(read).empty());
  body.triangles.push_back({0, 1, static_cast<int>(nodes)});
  EXPECT_THAT(saving(body), HasSubstr("corner"));
  body.triangles.pop_back();
  body.node_labels.pop_back();
  EXPECT_THAT(saving(body), HasSubstr("node_labels"));
  body.node_labels.clear();
  body.stress.conservativeResize(6 * nodes - 1, body.modes);
  EXPECT_THAT(saving(body), HasSubstr("stress"));
}

/// What the rest of the file contradicts, or what no elastic body has.
TEST_F(ReducedBodyFile, NamesChangedMatrices) {
  const ReducedBody sound = some_body();
  ASSERT_GT(sound.eigenfrequencies.size(), 0);
  ReducedBody body = sound;
  body.stiffness.setZero();
  EXPECT_THAT(saving(body), HasSubstr("stiffness must hold every mode"));
  body = sound;
  body.stiffness *= 1.1;
  EXPECT_THAT(saving(body), HasSubstr("eigenfrequency 1"));
  body = sound;
  body.damping = -1e-3 * sound.stiffness;
  EXPECT_THAT(saving(body), HasSubstr("damping"));
  body = sound;
  body.mass *= 1.1;  // against the mass matrix of its mesh
  EXPECT_THAT(saving(body), HasSubstr("mass"));
  body = sound;
  body.mesh_inertia.reset();
  body.checks = {{"mass", true, fmt::format("{:.6g} kg, the same in all directions to 1e-12", sound.mass)}};
  EXPECT_EQ(saving(body), "no error");
  body.mass *= 1.1;
  EXPECT_THAT(saving(body), HasSubstr("but the validation report has"));
}

TEST_F(ReducedBodyFile, MayHaveNoMeshInertiaOrNoNodalMass) {
  ReducedBody body = some_body();
  body.mesh_inertia->nodal_mass.resize(0, 0);
  save(body, path());
  EXPECT_EQ(load_reduced_body(path()).mesh_inertia->nodal_mass.size(), 0);
  body.mesh_inertia.reset();
  save(body, path());
  EXPECT_FALSE(load_reduced_body(path()).mesh_inertia);
}

TEST_F(ReducedBodyFile, NamesWhatIsWrongWithTheMeshInertia) {
  const std::string group = "group 'mesh_inertia': ";
  EXPECT_THAT(error_after([](hid_t file) { H5Ldelete(file, "mesh_inertia/mass", H5P_DEFAULT); }),
              HasSubstr(group + "group 'mass' is missing"));
  EXPECT_THAT(error_after([](hid_t file) { H5Ldelete(file, "mesh_inertia/shapes", H5P_DEFAULT); }),
              HasSubstr(group + "dataset 'shapes' is missing"));
  EXPECT_THAT(error_after([](hid_t file) {
                replace_dataset(file, "mesh_inertia/mass/places", {2, 2}, 1);
              }),
              HasSubstr(group + "dataset 'values' must be 2"));
  EXPECT_THAT(error_after([](hid_t file) {
                replace_dataset(file, "mesh_inertia/mass/places", {2, 2}, 1e6);
                replace_dataset(file, "mesh_inertia/mass/values", {2}, 1);
              }),
              HasSubstr(group + "'mass' has an entry at (1000000, 1000000), outside of"));
}

TEST_F(ReducedBodyFile, KeepsABodyWithoutModesFramesOrDrawing) {
  ReducedBody body;
  body.mass = 2;
  body.second_moment = Eigen::Vector3d(1, 2, 3).asDiagonal();
  body.S.resize(3, 0);
  for (auto& block : body.S_position) block.resize(3, 0);
  body.node_shapes.resize(0, 0);
  ASSERT_THAT(check(body), testing::IsEmpty());
  save(body, path());
  const ReducedBody read = load_reduced_body(path());
  EXPECT_EQ(read.name, "");
  EXPECT_EQ(read.mass, 2);
  EXPECT_EQ(read.modes, 0);
}

TEST_F(ReducedBodyFile, OfTheSameBodyHasTheSameBytesWheneverWritten) {
  save(some_body(), path("a.h5"));
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // HDF5 time stamps count seconds
  save(some_body(), path("b.h5"));
  EXPECT_TRUE(bytes(path("a.h5")) == bytes(path("b.h5")));
}

TEST_F(ReducedBodyFile, RefusesFilesThatAreNone) {
  EXPECT_THAT(load_error(path("absent.h5")), AllOf(HasSubstr("absent.h5"), HasSubstr("no such file")));
  write(path("text.h5"), "mimbre: 1\n");
  EXPECT_THAT(load_error(path("text.h5")),
              AllOf(HasSubstr("text.h5"), HasSubstr("not a complete HDF5 file")));
  write(path("empty.h5"), "");
  EXPECT_THAT(load_error(path("empty.h5")), HasSubstr("not a complete HDF5 file"));
}

TEST_F(ReducedBodyFile, RefusesEveryTruncation) {
  save(some_body(), path());
  const std::string whole = bytes(path());
  for (std::size_t size = 0; size < whole.size(); size += whole.size() / 50) {
    write(path("cut.h5"), whole.substr(0, size));
    EXPECT_NE(load_error(path("cut.h5")), "no error") << size;
  }
}

TEST_F(ReducedBodyFile, NamesWhatIsMissing) {
  for (const char* name :
       {"S", "S_modes", "mass_matrix", "mode_names", "lines", "nodes", "frames/0/X_theta"}) {
    const std::string leaf = std::string(name).substr(std::string(name).rfind('/') + 1);
    EXPECT_THAT(error_after([&](hid_t file) { H5Ldelete(file, name, H5P_DEFAULT); }),
                AllOf(HasSubstr("body.h5"), HasSubstr("dataset '" + leaf + "' is missing")));
  }
  EXPECT_THAT(error_after([](hid_t file) { H5Ldelete(file, "frames", H5P_DEFAULT); }),
              HasSubstr("group 'frames' is missing"));
  EXPECT_THAT(error_after([](hid_t file) { H5Ldelete(file, "frames/0", H5P_DEFAULT); }),
              HasSubstr("group 'frames/0' is missing"));
  EXPECT_THAT(error_after([](hid_t file) { H5Adelete(file, "mass"); }),
              HasSubstr("attribute 'mass' is missing"));
  EXPECT_THAT(error_after([](hid_t file) { H5Adelete(file, "format"); }),
              HasSubstr("attribute 'format' is missing"));
}

TEST_F(ReducedBodyFile, NamesWhatHasTheWrongShapeOrValues) {
  EXPECT_THAT(error_after([](hid_t file) {
                replace_dataset(file, "S", {3, 2}, 0);
              }),
              HasSubstr("dataset 'S' must be 3 x 4, is 3 x 2"));
  EXPECT_THAT(error_after([](hid_t file) { replace_dataset(file, "nodes", {12}, 0); }),
              HasSubstr("dataset 'nodes' must be any x 3, is 12"));
  EXPECT_THAT(error_after([](hid_t file) {
                replace_dataset(file, "nodes", {hsize_t{1} << 40, 3}, 0);
              }),
              HasSubstr("'nodes' is too large"));
  EXPECT_THAT(error_after([](hid_t file) { replace_dataset(file, "mode_names", {4}, 0); }),
              HasSubstr("'mode_names' must be text"));
  EXPECT_THAT(error_after([](hid_t file) {
                replace_dataset(file, "S", {3, 4}, std::nan(""));
              }),
              AllOf(HasSubstr("body.h5"), HasSubstr("S must be finite")));
  EXPECT_THAT(error_after([](hid_t file) {
                replace_dataset(file, "mass_matrix", {4, 4}, 1);
              }),
              HasSubstr("mass_matrix must be positive definite"));
}

TEST_F(ReducedBodyFile, CannotBeSavedWhereThereIsNoFolderNorFromAnUnsoundBody) {
  try {
    save(some_body(), path("none/body.h5"));
    FAIL() << "nothing thrown";
  } catch (const InputError&) {
    FAIL() << "the body is good";
  } catch (const std::runtime_error& problem) {
    EXPECT_THAT(problem.what(), AllOf(HasSubstr("none/body.h5"), HasSubstr("No such file or directory")));
  }
  ReducedBody unsound = some_body();
  unsound.node_shapes.resize(3, 1);
  EXPECT_THAT(saving(unsound),
              AllOf(HasSubstr("body.h5"), HasSubstr("node_shapes must be 24 x 4, is 3 x 1")));
  EXPECT_FALSE(std::filesystem::exists(path()));
}

}  // namespace
}  // namespace mimbre::test::reduced_body_file_test
