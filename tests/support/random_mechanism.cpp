#include "support/random_mechanism.h"

#include <array>
#include <cmath>
#include <map>

#include "fe/meshes.h"
#include "joints/table.h"
#include "reduction/stiffening/beside_rotation.h"
#include "spec/check/checked_item.h"
#include "spec/nearest_place.h"

namespace mimbre::test {

Vec3d Random::vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
Mat3d Random::rotation() { return rotation_exp<double>(vector(1.8)); }
spec::Pose Random::pose(double size) { return {vector(size), rotation()}; }
VectorXd Random::values(int count, double size) {
  VectorXd x(count);
  for (int k = 0; k < count; ++k) x[k] = number(-size, size);
  return x;
}

spec::Pose after(const spec::Pose& outer, const spec::Pose& inner) {
  return {outer.position + outer.rotation * inner.position, outer.rotation * inner.rotation};
}

spec::Pose inverse(const spec::Pose& p) {
  return {-(p.rotation.transpose() * p.position), p.rotation.transpose()};
}

ReducedBody mixed(ReducedBody b, const MatrixXd& mix) {
  b.S = (b.S * mix).eval();
  for (auto& s : b.S_position) s = (s * mix).eval();
  for (auto& row : b.S_modes)
    for (MatrixXd& s : row) s = (mix.transpose() * s * mix).eval();
  b.mass_matrix = (mix.transpose() * b.mass_matrix * mix).eval();
  b.stiffness = (mix.transpose() * b.stiffness * mix).eval();
  b.damping = (mix.transpose() * b.damping * mix).eval();
  for (BodyFrame& f : b.frames) {
    f.X = (f.X * mix).eval();
    f.X_theta = (f.X_theta * mix).eval();
  }
  if (b.geometric) {
    for (MatrixXd& k : b.geometric->stiffness) k = (mix.transpose() * k * mix).eval();
    b.geometric->boundary_loads = (b.geometric->boundary_loads * mix).eval();
  }
  if (b.stretching)
    for (MatrixXd& form : b.stretching->forms) {
      const MatrixXd T = beside_rotation(mix);
      form = (T.transpose() * form * T).eval();
    }
  b.user_from_modal = (b.user_from_modal * mix).eval();
  b.node_shapes = (b.node_shapes * mix).eval();
  if (b.mesh_inertia) b.mesh_inertia->shapes = (b.mesh_inertia->shapes * mix).eval();
  return b;
}

std::shared_ptr<const ReducedBody> random_flexible_body(int kind, fe::Stiffening stiffening) {
  constexpr int kinds = 10;
  static std::map<fe::Stiffening, std::array<std::shared_ptr<const ReducedBody>, kinds>> made;
  std::shared_ptr<const ReducedBody>& body = made[stiffening][static_cast<std::size_t>(kind % kinds)];
  if (body) return body;
  Random random(static_cast<unsigned>(1000 + kind % kinds));
  fe::Mesh mesh =
      with_nodes({random.vector(0.2), Vec3d(0.6, 0.1, 0.1) + random.vector(0.2),
                  Vec3d(0.8, 0.6, 0.2) + random.vector(0.2), Vec3d(0.5, -0.5, 0.3) + random.vector(0.2)});
  fe::Section section = rectangle(0.05, 0.03);
  const Vec3d y(0.1, 0.3, 1);
  add_bar(mesh, 0, 1, 2, section, y);
  add_bar(mesh, 1, 2, 2, section, y);
  add_bar(mesh, 1, 3, 2, section, y);
  for (fe::BeamElement& e : mesh.elements) e.material = {2e8, 0.3, 900};
  const int modes = 2 + kind % 5;
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.boundary.push_back({2, false, Vec3d::UnitX(), "x"});
  if (modes > 2) options.boundary.push_back({2, false, Vec3d::UnitZ(), "z"});
  if (modes > 3) options.boundary.push_back({3, true, Vec3d::UnitY(), "turn"});
  options.dynamic_modes = modes - static_cast<int>(options.boundary.size());
  options.stiffness_damping = 1e-3;
  options.stiffening = stiffening;
  ReducedBody reduced = fe::reduce(mesh, options,
                                   {{"clamped", 0, random.rotation()},
                                    {"first", 2, random.rotation()},
                                    {"second", 3, random.rotation()},
                                    {"middle", 1, random.rotation()}});
  if (kind % 2 == 1) {
    MatrixXd mix = MatrixXd::Identity(modes, modes);
    for (int k = 0; k < modes * modes; ++k) mix(k / modes, k % modes) += random.number(-0.3, 0.3);
    reduced = mixed(std::move(reduced), mix);
  }
  return body = std::make_shared<const ReducedBody>(std::move(reduced));
}

VectorXd assembled_position(const Compiled& m) {
  VectorXd q = VectorXd::Zero(m.positions);
  for (const BodyData& b : m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    if (info.quaternion >= 0) q[b.q + info.quaternion] = 1;
  }
  return q;
}

VectorXd random_increment(const Compiled& m, Random& random, double size) {
  VectorXd x = random.values(m.velocities, size);
  for (const BodyData& b : m.bodies) {
    if (b.modes == 0) continue;
    const ReducedBody& r = *m.spec().bodies[b.spec].flexible;
    double largest = 1e-9;
    for (const BodyFrame& f : r.frames)
      largest = std::max({largest, f.X.cwiseAbs().maxCoeff(), f.X_theta.cwiseAbs().maxCoeff()});
    x.segment(b.v + b.joint_velocities, b.modes) /= 3 * largest;
  }
  return x;
}

VectorXd random_position(const relative::RelativeSystem& system, Random& random, double size) {
  const VectorXd x = random_increment(system.model(), random, size);
  VectorXd q = assembled_position(system.model());
  system.retract(q.data(), x.data(), q.data());
  return q;
}
}  // namespace mimbre::test
namespace mimbre::test {
namespace {

spec::Body random_rigid_body(Random& random) {
  spec::Body body;
  body.mass = random.number(0.5, 3);
  body.com = random.vector(0.3);
  // Of three pairs of point masses along turned axes: any inertia that a body can have.
  const Mat3d axes = random.rotation();
  Mat3d second = Mat3d::Zero();
  for (int k = 0; k < 3; ++k) second += random.number(0.002, 0.05) * axes.col(k) * axes.col(k).transpose();
  body.inertia = second.trace() * Mat3d::Identity() - second;
  return body;
}

int random_frame(spec::Model& m, Random& random, int body) {
  spec::Frame f;
  f.name = "frame" + std::to_string(m.frames.size());
  f.body = body;
  f.pose = random.pose(0.5);
  if (body >= 0 && m.bodies[body].flexible) {
    const ReducedBody& r = *m.bodies[body].flexible;
    f.flexible_frame = random.index(static_cast<int>(r.frames.size()));
    f.pose.position = r.frames[f.flexible_frame].position;
  }
  m.frames.push_back(f);
  return static_cast<int>(m.frames.size()) - 1;
}

spec::Pose global_pose(const spec::Model& m, int frame) {
  const spec::Frame& f = m.frames[frame];
  return f.body < 0 ? f.pose : after(m.bodies[f.body].pose, f.pose);
}

std::vector<spec::Pose> frame_poses(const std::shared_ptr<const Model>& model, const VectorXd& q) {
  const Compiled& m = model->compiled();
  relative::RelativeSystem system(m);
  const VectorXd zero = VectorXd::Zero(m.velocities);
  system.kinematics(0, q.data(), zero.data(), zero.data());
  std::vector<spec::Pose> poses;
  for (std::size_t k = 0; k < m.spec().frames.size(); ++k) {
    const auto motion =
        relative::output_motion(system, m.frame_of_spec[k], q.data(), zero.data(), zero.data());
    poses.push_back({motion.position, motion.rotation});
  }
  return poses;
}
}  // namespace
}  // namespace mimbre::test
namespace mimbre::test {

RandomMechanism random_mechanism(unsigned seed, const RandomOptions& options) {
  using spec::JointType;
  Random random(seed);
  spec::Model m;
  m.gravity = options.gravity ? Vec3d(random.vector(6)) : Vec3d::Zero();
  int flexible_bodies = 0;
  for (int b = 0; b < options.bodies; ++b) {
    spec::Body body;
    if (random.chance(options.flexible_share)) {
      auto flexible = random_flexible_body(static_cast<int>(seed) + 3 * b, options.stiffening);
      if (!options.damping) {
        auto undamped = std::make_shared<ReducedBody>(*flexible);
        undamped->damping.setZero();
        flexible = undamped;
      }
      body.flexible = flexible;
      ++flexible_bodies;
    } else {
      body = random_rigid_body(random);
    }
    body.name = "body" + std::to_string(b);
    m.bodies.push_back(body);

    spec::Joint joint;
    joint.name = "joint" + std::to_string(b);
    joint.type = static_cast<JointType>((seed + 2 * static_cast<unsigned>(b)) % 9);
    if (!options.floating && joint.type == JointType::floating) joint.type = JointType::revolute;
    joint.cut = spec::Joint::Cut::never;
    // Branches and chains, both.
    const int parent = random.chance(0.6) ? b - 1 : random.index(b + 1) - 1;
    const int near = random_frame(m, random, parent), far = random_frame(m, random, b);
    m.bodies[b].pose = after(global_pose(m, near), inverse(m.frames[far].pose));
    const bool reversed = random.chance(0.4);
    joint.frame_a = reversed ? far : near;
    joint.frame_b = reversed ? near : far;
    m.joints.push_back(joint);
  }
  const auto any_body = [&] { return random.index(options.bodies); };
  const auto scalar_coordinate = [&](const spec::Joint& j) {
    const JointInfo& info = joint_info(j.type);
    const int scalars = info.quaternion < 0 ? info.velocities : info.rotation;
    return scalars == 0 ? -1 : random.index(scalars);
  };

  if (options.springs || options.damping) {
    for (int k = 0; k < 3; ++k) {
      spec::Spring s;
      s.name = "spring" + std::to_string(k);
      s.frame_a = random_frame(m, random, k == 0 ? spec::ground : any_body());
      // Between the frames of one joint, which may lie on each other, a spring has no direction.
      const auto at_one_place = [&](int a, int b) {
        return mimbre::at_one_place(checks::assembled_place(m, m.frames[a]),
                                    checks::assembled_place(m, m.frames[b]));
      };
      const auto joined = [&](int a, int b) {
        return std::any_of(m.joints.begin(), m.joints.end(), [&](const spec::Joint& j) {
          return (j.frame_a == a && j.frame_b == b) || (j.frame_a == b && j.frame_b == a);
        });
      };
      do s.frame_b = random_frame(m, random, any_body());
      while ((m.frames[s.frame_b].body == m.frames[s.frame_a].body && options.bodies > 1) ||
             joined(s.frame_a, s.frame_b) || at_one_place(s.frame_a, s.frame_b));
      if (options.springs) s.elastic = Function::polynomial({-20, 30, 15, 8});
      if (options.damping) {
        s.damping = Function::polynomial({0, 4, 1.5, 0.5});
        if (k == 1)
          s.general = {Formula::expression("3*sin(l)*v + 2*cos(t)*l", {"l", "v", "t"}), {spec::Source{}}};
      }
      m.springs.push_back(s);
    }
    for (spec::Joint& j : m.joints) {
      const int coordinate = scalar_coordinate(j);
      if (coordinate < 0 || random.chance(0.4)) continue;
      spec::JointSpring s;
      s.coordinate = coordinate;
      if (options.springs) s.elastic = Function::polynomial({1, 7, 2, 1.5});
      if (options.damping) s.damping = Function::polynomial({0, 2, 0, 0.3});
      j.springs.push_back(s);
    }
  }
  if (options.tyres) {
    spec::Road& road = m.roads.emplace_back();
    road.name = "road";
    road.height = Function::constant(0.1);
    for (int k = 0; k < 2; ++k) {
      spec::Tyre tyre;
      tyre.name = "tyre" + std::to_string(k);
      tyre.frame = random_frame(m, random, any_body());
      tyre.road = 0;
      tyre.stiffness = 150.0 + 50 * k;
      tyre.radius = k == 0 ? 10.0 : 0.3;
      m.tyres.push_back(tyre);
    }
  }
  if (options.loads) {
    for (int k = 0; k < 3; ++k) {
      spec::Load l;
      l.name = "load" + std::to_string(k);
      l.frame = random_frame(m, random, any_body());
      l.force = random.vector(5);
      l.moment = random.vector(2);
      l.scale = Function::polynomial({1, 0.5, 0.25});
      l.follower = k == 1;
      m.loads.push_back(l);
    }
  }

  // A position of the tree, then loops that are closed there.
  const auto tree = Model::compile(m);
  relative::RelativeSystem system(tree->compiled());
  const VectorXd q = random_position(system, random, 0.8);
  if (options.drives) {
    int driven = 0;
    for (const BodyData& b : tree->compiled().bodies) {
      spec::Joint& j = m.joints[b.joint_spec];
      const int coordinate = scalar_coordinate(j);
      if (coordinate < 0 || driven == 2) continue;
      j.drives.push_back({coordinate, Function::polynomial({q[b.q + coordinate], 0.7, -0.4, 0.2})});
      ++driven;
    }
  }
  const std::vector<spec::Pose> poses = frame_poses(tree, q);
  const std::size_t tree_frames = poses.size();
  for (int k = 0; k < options.loops; ++k) {
    spec::Joint joint;
    joint.name = "loop" + std::to_string(k);
    joint.type =
        static_cast<JointType>((seed / 2 + static_cast<unsigned>(k)) % 8);  // floating closes nothing
    joint.cut = spec::Joint::Cut::always;
    // From a frame that exists to a new one on a rigid body, or to the ground.
    const int from = random.index(static_cast<int>(tree_frames));
    std::vector<int> candidates;
    for (int b = -1; b < options.bodies; ++b)
      if (b != m.frames[from].body && (b < 0 || !m.bodies[b].flexible)) candidates.push_back(b);
    if (candidates.empty()) continue;
    const int to = candidates[static_cast<std::size_t>(random.index(static_cast<int>(candidates.size())))];
    JointMotion<double> motion;
    const JointInfo& info = joint_info(joint.type);
    std::array<double, 7> coordinate{};
    const std::array<double, 6> rates{};
    for (double& x : coordinate) x = random.number(-0.5, 0.5);
    if (info.quaternion >= 0) {
      const Quat<double> turn = quaternion_exp<double>(random.vector(0.5));
      for (int i = 0; i < 4; ++i) coordinate[static_cast<std::size_t>(info.quaternion + i)] = turn[i];
    }
    joint_motion<double>(joint.type, coordinate.data(), rates.data(), motion);
    const bool reversed = random.chance(0.5);
    const spec::Pose relative{motion.displacement, motion.rotation};
    const spec::Pose target =
        after(poses[static_cast<std::size_t>(from)], reversed ? inverse(relative) : relative);
    // The carrier's pose at q from any of its frames.
    spec::Frame f;
    f.name = "closing" + std::to_string(k);
    f.body = to;
    f.pose = target;
    if (to >= 0) {
      std::size_t known = 0;
      while (m.frames[known].body != to) ++known;
      f.pose = after(after(m.frames[known].pose, inverse(poses[known])), target);
    }
    m.frames.push_back(f);
    const int added = static_cast<int>(m.frames.size()) - 1;
    joint.frame_a = reversed ? added : from;
    joint.frame_b = reversed ? from : added;
    m.joints.push_back(joint);
  }
  RandomMechanism result;
  result.model = Model::compile(m);
  result.q = q;
  return result;
}

}  // namespace mimbre::test
