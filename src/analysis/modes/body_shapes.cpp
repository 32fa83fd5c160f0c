#include "analysis/modes/body_shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "analysis/observed_rows.h"
#include "dynamics/amplitudes.h"
#include "math/elementary.h"
#include "math/rotation.h"
#include "simulation/observe/channels.h"

namespace mimbre {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;
using std::complex;

namespace {

/// Of a body's points so many are looked at for the largest displacement.
constexpr Index most_points = 400;

/// Points of a body by which its motion is seen.
struct SeenBody {
  Eigen::Matrix3Xd levers;  ///< from its origin, deformed as at the point, global axes
  MatrixXd shapes;          ///< 3·points × amplitudes, global axes
  Index first = 0;          ///< of its amplitudes among all
};

/// Largest |Re(x e^{iφ})|.
double amplitude_of(const Eigen::Vector3cd& x) {
  const complex<double> square = (x.transpose() * x).value();
  return std::sqrt(0.5 * (x.squaredNorm() + std::abs(square)));
}

void add_corners(const spec::Shape& shape, std::vector<Vec3d>& points) {
  Vec3d half = 0.5 * shape.size;
  if (shape.kind == spec::Shape::Kind::cylinder) half = {shape.size[0], shape.size[0], 0.5 * shape.size[1]};
  if (shape.kind == spec::Shape::Kind::sphere) half.setConstant(shape.size[0]);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d signs((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
    points.emplace_back(shape.pose.rotation * signs.cwiseProduct(half) + shape.pose.position);
  }
}

/// Mesh points, corners of solids, frames of what holds or moves the body; of one that is not drawn its
/// centre of mass.
SeenBody seen_body(const MechanismShapes& all, std::size_t body, Index first, const Vec3d& centre) {
  const BodyDrawing& drawn = all.header.bodies[body];
  std::vector<Vec3d> points;
  std::vector<MatrixXd> shapes;  // 3 × amplitudes
  const MatrixXd rigid = MatrixXd::Zero(3, drawn.modes);
  const Index count = drawn.points.cols(), every = 1 + count / most_points;
  for (Index k = 0; k < count; k += every) {
    points.emplace_back(drawn.points.col(k));
    shapes.emplace_back(drawn.point_shapes.cols() > 0 ? MatrixXd(drawn.point_shapes.middleRows<3>(3 * k))
                                                      : rigid);
  }
  for (const spec::Shape& shape : drawn.shapes) add_corners(shape, points);
  shapes.resize(points.size(), rigid);
  for (const FrameDrawing& frame : all.header.frames) {
    if (frame.body != static_cast<int>(body)) continue;
    points.push_back(frame.pose.position);
    shapes.emplace_back(frame.motion.cols() > 0 ? MatrixXd(frame.motion.topRows<3>()) : rigid);
  }
  if (count == 0 && drawn.shapes.empty()) {
    points.push_back(centre);
    shapes.push_back(rigid);
  }
  const auto pose = all.at.poses.col(static_cast<Index>(body));
  const Mat3d R = Eigen::Quaterniond(pose[3], pose[4], pose[5], pose[6]).toRotationMatrix();
  const VectorXd deformed = all.at.modes.segment(first, drawn.modes);
  SeenBody out{Eigen::Matrix3Xd(3, std::ssize(points)), MatrixXd(3 * std::ssize(points), drawn.modes), first};
  for (Index k = 0; k < out.levers.cols(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    out.shapes.middleRows<3>(3 * k) = R * shapes[i];
    out.levers.col(k) = R * points[i] + out.shapes.middleRows<3>(3 * k) * deformed;
  }
  return out;
}

/// Bodies of the model; the ground, where it is drawn, is not among them.
std::vector<SeenBody> seen_bodies(const spec::Model& spec, const MechanismShapes& all) {
  std::vector<SeenBody> out;
  Index first = 0;
  for (std::size_t k = 0; k < spec.bodies.size(); ++k) {
    out.push_back(seen_body(all, k, first, spec.bodies[k].com));
    first += all.header.bodies[k].modes;
  }
  return out;
}

double size_of(const MechanismShapes& all, const std::vector<SeenBody>& bodies) {
  Eigen::AlignedBox3d box;
  for (std::size_t k = 0; k < bodies.size(); ++k)
    for (const auto& lever : bodies[k].levers.colwise())
      box.extend(Vec3d(all.at.poses.col(static_cast<Index>(k)).head<3>() + lever));
  for (const ElementDrawing& element : all.header.elements)
    for (const int end : {element.frame_a, element.frame_b}) {
      if (end < 0 || element.kind == "floating") continue;
      const FrameDrawing& frame = all.header.frames[static_cast<std::size_t>(end)];
      if (frame.body == spec::ground) box.extend(frame.pose.position);
    }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

void find_reach(const std::vector<SeenBody>& bodies, BodyShapes& mode) {
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const SeenBody& body = bodies[k];
    const Eigen::Vector3cd d = mode.displacement.col(static_cast<Index>(k)),
                           turn = mode.turn.col(static_cast<Index>(k));
    mode.largest_turn = std::max(mode.largest_turn, amplitude_of(turn));
    const Index modes = body.shapes.cols();
    const VectorXcd deflection =
        modes > 0
            ? VectorXcd(body.shapes.cast<complex<double>>() * mode.amplitudes.segment(body.first, modes))
            : VectorXcd(VectorXcd::Zero(body.shapes.rows()));
    for (Index p = 0; p < body.levers.cols(); ++p) {
      // By a matrix: Eigen's cross product of complex vectors is the conjugate one.
      const Mat3d lever = skew<double>(body.levers.col(p));
      const Eigen::Vector3cd moved = d - lever.cast<complex<double>>() * turn + deflection.segment<3>(3 * p);
      mode.reach = std::max(mode.reach, amplitude_of(moved));
    }
  }
}

/// Velocities of bodies and rates of amplitudes.
class BodyRates {
 public:
  explicit BodyRates(const linear::Linearised& at) : at_(at), m_(at.model->compiled()), system_(m_) {
    system_.enter_rest(at.state.u.data(), at.state.z.data());
    system_.begin_step(at.state.q.data());
    none_ = rates(VectorXd::Zero(m_.velocities));
  }

  BodyShapes shapes(const VectorXcd& motion, Index columns) {
    const Rates real = rates(motion.real()), imaginary = rates(motion.imag());
    BodyShapes out;
    const auto bodies = std::ssize(m_.spec().bodies);
    out.displacement.setZero(3, columns);
    out.turn.setZero(3, columns);
    // What drives move whatever the coordinates do is no part of the mode.
    const auto joined = [&](const auto& of) {
      return (of(real) - of(none_)).template cast<complex<double>>() +
             complex<double>(0, 1) * (of(imaginary) - of(none_)).template cast<complex<double>>();
    };
    out.displacement.leftCols(bodies) = joined([](const Rates& r) -> const MatrixXd& { return r.velocity; });
    out.turn.leftCols(bodies) = joined([](const Rates& r) -> const MatrixXd& { return r.omega; });
    out.amplitudes = joined([](const Rates& r) -> const VectorXd& { return r.amplitudes; });
    return out;
  }

  /// In the positions of the point.
  const relative::RelativeSystem& system() const { return system_; }

 private:
  struct Rates {
    MatrixXd velocity, omega;
    VectorXd amplitudes;
  };
  Rates rates(const VectorXd& v) {
    const State& s = at_.state;
    const VectorXd zero = VectorXd::Zero(m_.velocities);
    system_.kinematics(s.time, s.q.data(), v.data(), zero.data());
    const auto& bodies = m_.spec().bodies;
    Rates out{MatrixXd(3, std::ssize(bodies)), MatrixXd(3, std::ssize(bodies)), {}};
    std::vector<double> amplitudes;
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const auto place = m_.body_of_spec[k];
      const Motion<double>& motion = system_.workspace().bodies[place];
      out.velocity.col(static_cast<Index>(k)) = motion.velocity;
      out.omega.col(static_cast<Index>(k)) = motion.omega;
      const BodyData& b = m_.bodies[place];
      if (b.modes == 0) continue;
      const FlexibleData& f = m_.flexible[b.flexible];
      VectorXd y = VectorXd::Zero(f.stride), rate = y;
      y.head(b.modes) = s.q.segment(b.q + b.joint_positions, b.modes);
      rate.head(b.modes) = v.segment(b.v + b.joint_velocities, b.modes);
      extend(f, y.data(), rate.data());
      amplitudes.insert(amplitudes.end(), rate.data(), rate.data() + f.modes);
    }
    out.amplitudes = Eigen::Map<const VectorXd>(amplitudes.data(), std::ssize(amplitudes));
    return out;
  }

  const linear::Linearised& at_;
  const Compiled& m_;
  relative::RelativeSystem system_;
  Rates none_;
};

}  // namespace

MechanismShapes linear::body_shapes(const Linearised& at, const std::vector<Mode>& modes) {
  const Compiled& m = at.model->compiled();
  MechanismShapes out;
  out.header = ObservedRows(m, false).header("");
  out.header.channels.clear();
  BodyRates rates(at);
  Channels(m).picture(rates.system(), at.state, out.at);
  out.axis = at.turning_axis;
  out.place = at.turning_place + rates.system().workspace().origin;
  const std::vector<SeenBody> bodies = seen_bodies(m.spec(), out);
  out.size = size_of(out, bodies);
  for (const Mode& mode : modes) {
    out.modes.push_back(rates.shapes(mode.motion, out.at.poses.cols()));
    find_reach(bodies, out.modes.back());
  }
  return out;
}

double drawing_factor(const MechanismShapes& shapes, int mode, double share) {
  constexpr double turn = 6;  // rad, for a share of 1
  const BodyShapes& one = shapes.modes[static_cast<std::size_t>(mode)];
  // A single point is drawn as if it were 1 m large.
  const double size = shapes.size > 0 ? shapes.size : 1,
               by_reach = one.reach > 0 ? share * size / one.reach : 0,
               by_turn = one.largest_turn > 0 ? share * turn / one.largest_turn : 0;
  if (by_reach > 0 && by_turn > 0) return std::min(by_reach, by_turn);
  return std::max(by_reach, by_turn);
}

ResultsRow moved_by_mode(const MechanismShapes& shapes, int mode, double factor, double phase) {
  const BodyShapes& one = shapes.modes[static_cast<std::size_t>(mode)];
  const complex<double> turned = factor * complex<double>(mimbre::cos(phase), mimbre::sin(phase));
  ResultsRow row = shapes.at;
  for (Index k = 0; k < row.poses.cols(); ++k) {
    const Vec3d d = (turned * one.displacement.col(k)).real(), turn = (turned * one.turn.col(k)).real();
    auto pose = row.poses.col(k);
    pose.head<3>() += left_jacobian<double>(turn) * d;
    const Quat<double> before = pose.tail<4>();
    pose.tail<4>() = quaternion_of(Mat3d(rotation_exp<double>(turn) * rotation_matrix<double>(before)));
  }
  row.modes += (turned * one.amplitudes).real();
  return row;
}

}  // namespace mimbre
