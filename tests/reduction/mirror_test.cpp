#include "reduction/file/mirror.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "fe/meshes.h"
#include "mimbre/simulation.h"
#include "support/models.h"
#include "support/random_mechanism.h"

/// Mirror images of reduced bodies, against reductions of the mirrored mesh and against mirrored motions.
namespace mimbre::test::mirror_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using fe::Stiffening;

const std::vector<Vector3d> mirrors{{-1, 1, 1},  {1, -1, 1},  {1, 1, -1},
                                    {-1, -1, 1}, {1, -1, -1}, {-1, -1, -1}};

std::string name_of(const Vector3d& signs) {
  std::string name;
  for (int k = 0; k < 3; ++k)
    if (signs[k] < 0) name += "xyz"[k];
  return name;
}

/// All numbers of a body, with their names.
using Numbers = std::vector<std::pair<std::string, MatrixXd>>;

template <class Integrals>
void add_integrals(Numbers& all, const std::string& of, const Integrals& s) {
  all.emplace_back(of + "S", s.S);
  for (std::size_t i = 0; i < 3; ++i) {
    all.emplace_back(fmt::format("{}S_position[{}]", of, i), s.S_position[i]);
    for (std::size_t j = 0; j < 3; ++j)
      all.emplace_back(fmt::format("{}S_modes[{}][{}]", of, i, j), s.S_modes[i][j]);
  }
  all.emplace_back(of + "mass_matrix", s.mass_matrix);
  all.emplace_back(of + "stiffness", s.stiffness);
}

Numbers numbers_of(const ReducedBody& b) {
  Numbers all{{"first_moment", b.first_moment},
              {"second_moment", b.second_moment},
              {"damping", b.damping},
              {"user_from_modal", b.user_from_modal},
              {"nodes", b.nodes},
              {"node_shapes", b.node_shapes},
              {"stress", b.stress},
              {"strain", b.strain}};
  add_integrals(all, "", b);
  for (const BodyFrame& f : b.frames) {
    all.emplace_back(f.name + ".position", f.position);
    all.emplace_back(f.name + ".rotation", f.rotation);
    all.emplace_back(f.name + ".X", f.X);
    all.emplace_back(f.name + ".X_theta", f.X_theta);
  }
  if (b.second_order) {
    add_integrals(all, "second ", *b.second_order);
    for (const auto& X : b.second_order->frame_shapes) all.emplace_back("second X", X);
    all.emplace_back("second node_shapes", b.second_order->node_shapes);
    all.emplace_back("second mesh_shapes", b.second_order->mesh_shapes);
  }
  if (b.geometric) {
    for (std::size_t k = 0; k < b.geometric->loads.size(); ++k)
      all.emplace_back(fmt::format("geometric, load {}", b.geometric->loads[k]), b.geometric->stiffness[k]);
    all.emplace_back("boundary_loads", b.geometric->boundary_loads);
  }
  if (b.ancf) {
    all.emplace_back("along", b.ancf->along);
    all.emplace_back("normal", b.ancf->normal);
  }
  if (b.mesh_inertia) {
    all.emplace_back("mesh mass", MatrixXd(b.mesh_inertia->mass));
    all.emplace_back("mesh nodal mass", MatrixXd(b.mesh_inertia->nodal_mass));
    all.emplace_back("mesh shapes", b.mesh_inertia->shapes);
  }
  return all;
}

/// `tolerance` is relative to the largest number of each matrix.
void expect_same(const ReducedBody& a, const ReducedBody& b, double tolerance, const std::string& what) {
  const Numbers x = numbers_of(a), y = numbers_of(b);
  ASSERT_EQ(x.size(), y.size()) << what;
  for (std::size_t k = 0; k < x.size(); ++k) {
    ASSERT_EQ(x[k].first, y[k].first) << what;
    ASSERT_EQ(x[k].second.rows(), y[k].second.rows()) << x[k].first;
    ASSERT_EQ(x[k].second.cols(), y[k].second.cols()) << x[k].first;
    if (x[k].second.size() == 0) continue;
    EXPECT_LE((x[k].second - y[k].second).cwiseAbs().maxCoeff(),
              tolerance * std::max(1e-3, y[k].second.cwiseAbs().maxCoeff()))
        << what << ": " << x[k].first << '\n'
        << x[k].second << "\nagainst\n"
        << y[k].second;
  }
}

/// A bent frame of bars and its mirror image, reduced each for itself.
ReducedBody bent(Stiffening stiffening, const Vector3d& signs) {
  const Matrix3d M = signs.asDiagonal();
  fe::Mesh mesh = with_nodes({Vector3d(0.1, 0.2, -0.1), Vector3d(0.9, 0.4, 0.3), Vector3d(1.3, -0.5, 0.9)});
  add_bar(mesh, 0, 1, 3, rectangle(0.05, 0.03), {0.1, 0.2, 1});
  add_bar(mesh, 1, 2, 2, rectangle(0.04, 0.02), {0.3, 0.1, 1});
  mesh.nodes = (M * mesh.nodes).eval();
  for (fe::BeamElement& e : mesh.elements) e.y_direction = (M * e.y_direction).eval();
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.boundary = {{2, false, M * Vector3d::UnitZ(), "z"},
                      {2, true, signs.prod() * M * Vector3d::UnitX(), "turn"}};
  options.dynamic_modes = 2;
  options.stiffness_damping = 1e-3;
  options.stiffening = stiffening;
  const Matrix3d axes = some_rotation();
  return fe::reduce(mesh, options, {{"knee", 1, Matrix3d::Identity()}, {"tip", 2, M * axes * M}});
}

/// Eigenvectors have any sign, before and after they are made orthogonal: those of `like`.
ReducedBody with_signs_of(const ReducedBody& body, const ReducedBody& like) {
  VectorXd signs(body.modes);
  for (Eigen::Index k = 0; k < body.modes; ++k)
    signs[k] = body.node_shapes.col(k).dot(like.node_shapes.col(k)) < 0 ? -1 : 1;
  ReducedBody result = mixed(body, signs.asDiagonal());
  for (Eigen::Index k = 0; k < body.modes; ++k)
    if (result.user_from_modal.row(k).dot(like.user_from_modal.row(k)) < 0)
      result.user_from_modal.row(k) *= -1;
  if (!result.second_order) return result;
  SecondOrder& s = *result.second_order;
  VectorXd extended(s.mass_matrix.rows());
  extended.head(body.modes) = signs;
  for (std::size_t p = 0; p < s.products.size(); ++p)
    extended[body.modes + static_cast<Eigen::Index>(p)] = signs[s.products[p][0]] * signs[s.products[p][1]];
  const auto columns = [&](auto& m) { m = (m * extended.asDiagonal()).eval(); };
  const auto both = [&](MatrixXd& m) { m = (extended.asDiagonal() * m * extended.asDiagonal()).eval(); };
  columns(s.S);
  for (auto& m : s.S_position) columns(m);
  for (auto& row : s.S_modes)
    for (auto& m : row) both(m);
  both(s.mass_matrix);
  both(s.stiffness);
  for (auto& m : s.frame_shapes) columns(m);
  columns(s.node_shapes);
  columns(s.mesh_shapes);
  return result;
}

TEST(Mirror, IsTheReductionOfTheMirroredMesh) {
  for (const Stiffening stiffening :
       {Stiffening::linear, Stiffening::foreshortening, Stiffening::geometric_stiffness}) {
    const ReducedBody body = bent(stiffening, Vector3d::Ones());
    ASSERT_TRUE(body.mesh_inertia);
    for (const Vector3d& signs : mirrors) {
      const ReducedBody image = mirrored(body, signs);
      EXPECT_TRUE(check(image).empty()) << check(image).front();
      expect_same(with_signs_of(bent(stiffening, signs), image), image, 1e-6, name_of(signs));
    }
  }
}

TEST(Mirror, OfAbsoluteNodalCoordinates) {
  const auto beam = [](const Vector3d& signs) {
    const Matrix3d R = some_rotation(), M = signs.asDiagonal();
    fe::Mesh mesh = with_nodes({Vector3d(0.1, 0.2, 0.3), Vector3d(0.1, 0.2, 0.3) + R.col(0)});
    add_bar(mesh, 0, 1, 3, rectangle(0.05, 0.03), R.col(1));
    mesh.nodes = (M * mesh.nodes).eval();
    for (fe::BeamElement& e : mesh.elements) e.y_direction = (M * e.y_direction).eval();
    return fe::ancf_beam(mesh, {AncfKind::planar, 0, signs.prod() * M * R.col(2), 0.01},
                         {{"tip", 1, M * R * M}});
  };
  const ReducedBody body = beam(Vector3d::Ones());
  for (const Vector3d& signs : mirrors)
    expect_same(mirrored(body, signs), beam(signs), 1e-12, name_of(signs));
}

/// With a surface and random stresses.
ReducedBody with_surface(ReducedBody body) {
  Random random(7);
  for (int k = 0; k + 2 < body.nodes.cols(); ++k) body.triangles.push_back({k, k + 1, k + 2});
  for (MatrixXd* m : {&body.stress, &body.strain}) {
    m->resize(6 * body.nodes.cols(), body.modes);
    for (Eigen::Index k = 0; k < m->size(); ++k) m->data()[k] = random.number(-1, 1);
  }
  return body;
}

TEST(Mirror, TwiceIsTheSameBody) {
  for (const Stiffening stiffening :
       {Stiffening::linear, Stiffening::foreshortening, Stiffening::geometric_stiffness})
    for (const Vector3d& signs : mirrors) {
      const ReducedBody body = with_surface(*random_flexible_body(4, stiffening));
      const ReducedBody twice = mirrored(mirrored(body, signs), signs);
      expect_same(twice, body, 0, name_of(signs));
      EXPECT_EQ(twice.triangles, body.triangles);
    }
}

Matrix3d tensor(const MatrixXd& six, Eigen::Index node, Eigen::Index mode) {
  const auto s = six.col(mode).segment<6>(6 * node);
  return (Matrix3d() << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]).finished();
}

TEST(Mirror, TurnsTheSurfaceAndItsStresses) {
  const ReducedBody body = with_surface(*random_flexible_body(2));
  const auto normal = [](const ReducedBody& b, std::size_t k) {
    const auto& [p, q, r] = b.triangles[k];
    return Vector3d(Vector3d(b.nodes.col(q) - b.nodes.col(p)).cross(b.nodes.col(r) - b.nodes.col(p)));
  };
  for (const Vector3d& signs : mirrors) {
    const ReducedBody image = mirrored(body, signs);
    const Matrix3d M = signs.asDiagonal();
    for (std::size_t k = 0; k < body.triangles.size(); ++k)
      EXPECT_LT((normal(image, k) - M * normal(body, k)).norm(), 1e-15);
    for (Eigen::Index node = 0; node < body.nodes.cols(); ++node) {
      EXPECT_EQ(tensor(image.stress, node, 1), M * tensor(body.stress, node, 1) * M);
      EXPECT_EQ(tensor(image.strain, node, 0), M * tensor(body.strain, node, 0) * M);
    }
  }
}

/// A body of a file on a hinge, with a weight on one of its ends and a force on the other, in a template that
/// is placed once.
class MirroredBodyFile : public testing::Test {
 protected:
  void SetUp() override {
    folder = std::filesystem::path(testing::TempDir()) / ("mimbre_mirror_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder);
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  std::shared_ptr<const Model> mechanism(const ReducedBody& body, const spec::Body& placed, bool image,
                                         const Vector3d& gravity, const std::string& instance) const {
    save(body, (folder / "body.h5").string());
    const auto text = [](const Vector3d& v) {
      return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
    };
    const Vector3d end = placed.pose.position +
                         placed.pose.rotation * body.frames[std::size_t(body.find_frame("second"))].position;
    const std::string model = fmt::format(
        R"(mimbre: 1
title: test
gravity: {}
subsystems:
  side:
    bodies:
      bar: {{frame: {{at: {}, x: {}, y: {}}}, reduced: body.h5}}
      weight: {{mass: 0.4, com: {}, inertia: [0.002, 0.003, 0.004, 0.0005, 0.0002, -0.0003]}}
    joints:
      hinge: {{type: revolute, between: [ground, bar.clamped], axis: [1, 2, 3], velocity: 1.5}}
      link: {{type: universal, between: [bar.second, weight], axis: [1, 1, 0], axis2: [-1, 1, 1]}}
    loads:
      push: {{on: bar.first, force: [3, -2, 1], moment: [0.3, 0.2, -0.1], scale: "1 + t"}}
    outputs:
      - {{name: angle, joint: hinge}}
instances:
  {}
simulation: {{step: 0.0005, end: 1, tolerance: 1e-10}}
)",
        text(gravity), text(placed.pose.position), text(placed.pose.rotation.col(0)),
        text(placed.pose.rotation.col(1)), text(end + Vector3d(0.05, 0.1, -0.2)), instance);
    const auto compiled = Model::compile(parse_model(model, "mirror.yaml", folder.string()));
    EXPECT_EQ(compiled->spec().bodies[0].flexible->nodes.col(1) == body.nodes.col(1), !image);
    return compiled;
  }

  std::filesystem::path folder;
};

/// Natural coordinates are of points that are not chosen as mirror images, so that only motions in the limit
/// of small steps are the same there.
void expect_mirrored_motion(const std::shared_ptr<const Model>& original,
                            const std::shared_ptr<const Model>& image, const RunOptions& options,
                            const Matrix3d& M, const spec::Pose& moved, const std::string& what) {
  Simulation a(original, options), b(image, options);
  ResultsRow p, q;
  double worst = 0, most = 0;
  for (int step = 0; step < 100; ++step) {
    const StepReport here = a.step(), there = b.step();
    ASSERT_TRUE(here.ok() && there.ok()) << what << ": " << a.explain(here) << ", " << b.explain(there);
    a.sample(p);
    b.sample(q);
    const auto turn = [](const ResultsRow& row, Eigen::Index body) {
      const auto pose = row.poses.col(body);
      return Eigen::Quaterniond(pose[3], pose[4], pose[5], pose[6]).toRotationMatrix();
    };
    for (Eigen::Index k = 0; k < 2; ++k) {
      const Vector3d place = moved.rotation * M * p.poses.col(k).head<3>() + moved.position;
      worst = std::max({worst, (q.poses.col(k).head<3>() - place).norm(),
                        (turn(q, k) - moved.rotation * M * turn(p, k) * M).norm()});
    }
    worst =
        std::max({worst, (p.modes - q.modes).cwiseAbs().maxCoeff(), std::abs(p.channels[0] - q.channels[0])});
    most = std::max(most, p.modes.cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 1e-9) << what;
  EXPECT_GT(most, 1e-3) << what;
}

TEST_F(MirroredBodyFile, MovesAsTheMirrorImage) {
  using Simulation = spec::Simulation;
  const Vector3d gravity(1, -3, -9), at(1, -2, 0.5), turned(0.4, -0.7, 1.1);
  spec::Body placed;
  placed.pose = {Vector3d(0.1, 0.2, 0.3), some_rotation()};
  const std::string rotate = "at: [1, -2, 0.5], rotate: [0.4, -0.7, 1.1]";
  for (const Stiffening stiffening :
       {Stiffening::linear, Stiffening::foreshortening, Stiffening::geometric_stiffness}) {
    const ReducedBody body = *random_flexible_body(4, stiffening);
    const auto original = mechanism(body, placed, false, gravity, "plain: {of: side}");
    for (const Vector3d& signs : {Vector3d(1, -1, 1), Vector3d(-1, -1, 1)}) {
      const Matrix3d M = signs.asDiagonal();
      const spec::Pose moved{at, rotation_exp<double>(turned)};
      const auto image =
          mechanism(body, placed, true, moved.rotation * M * gravity,
                    fmt::format("image: {{of: side, mirror: {}, {}}}", name_of(signs), rotate));
      for (const auto formulation : {Simulation::Formulation::relative, Simulation::Formulation::natural})
        for (const auto inertia : {Simulation::Inertia::integrals, Simulation::Inertia::projection}) {
          RunOptions options;
          options.formulation = formulation;
          options.inertia = inertia;
          expect_mirrored_motion(original, image, options, M, moved,
                                 fmt::format("mirror {}, stiffening {}, formulation {}, inertia {}",
                                             name_of(signs), static_cast<int>(stiffening),
                                             static_cast<int>(formulation), static_cast<int>(inertia)));
        }
    }
  }
}

TEST_F(MirroredBodyFile, IsSharedByInstancesMirroredAlike) {
  save(*random_flexible_body(3), (folder / "body.h5").string());
  const auto model = parse_model(R"(mimbre: 1
subsystems:
  side:
    bodies: {bar: {frame: {at: [1, 0, 0]}, reduced: body.h5}}
instances:
  a: {of: side, mirror: y}
  b: {of: side, mirror: y, at: [1, 2, 3], rotate: [0, 0, 1]}
  c: {of: side, mirror: xy}
  d: {of: side, rotate: [0, 1, 0]}
bodies: {bar: {frame: {at: [0, 0, 0]}, reduced: body.h5}}
)",
                                 "shared.yaml", folder.string());
  const auto body = [&](const std::string& name) {
    for (const spec::Body& b : model.bodies)
      if (b.name == name) return b.flexible;
    return std::shared_ptr<const ReducedBody>();
  };
  ASSERT_TRUE(body("bar"));
  EXPECT_EQ(body("a.bar"), body("b.bar"));
  EXPECT_EQ(body("d.bar"), body("bar"));
  EXPECT_NE(body("a.bar"), body("bar"));
  EXPECT_NE(body("a.bar"), body("c.bar"));
}

}  // namespace
}  // namespace mimbre::test::mirror_test
