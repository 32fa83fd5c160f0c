#include "analysis/rigid_response.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>

#include "mimbre/model.h"
#include "mimbre/reduced_body.h"

namespace mimbre {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// A force and a moment on one of the body's frames at its origin, global axes.
struct FrameWrench {
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();
};

/// The model with the body rigid, and outputs of all that acts on it.
class RigidModel {
 public:
  RigidModel(const spec::Model& model, int body)
      : model_(model), body_(body), flexible_(*model.bodies[static_cast<std::size_t>(body)].flexible) {
    refuse_what_is_not_followed(model);
    model_.outputs.clear();
    spec::Body& b = model_.bodies[static_cast<std::size_t>(body)];
    b.mass = flexible_.mass;
    b.com = flexible_.first_moment / flexible_.mass;
    const Matrix3d second = flexible_.second_moment - flexible_.mass * b.com * b.com.transpose();
    b.inertia = second.trace() * Matrix3d::Identity() - second;
    b.flexible = nullptr;
    for (spec::Frame& frame : model_.frames)
      if (frame.body == body) frame.flexible_frame = -1;
    for (int k = 0; k < 4; ++k) {
      spec::Frame frame;
      frame.name = "rigid response " + std::to_string(k);
      frame.body = body;
      if (k > 0) frame.pose.position = Vector3d::Unit(k - 1);
      model_.frames.push_back(frame);
      accelerations_[static_cast<std::size_t>(k)] =
          vector_output("acceleration", static_cast<int>(model_.frames.size()) - 1);
    }
    for (std::size_t k = 0; k < model.joints.size(); ++k) {
      const spec::Joint& joint = model.joints[k];
      const bool a = on_body(joint.frame_a), second_is = on_body(joint.frame_b);
      if (a == second_is) continue;
      const int at = vector_output("joint_force", static_cast<int>(k));
      vector_output("joint_force", static_cast<int>(k), 3);
      const int places = vector_output("position", joint.frame_b);
      joints_.push_back({at, places, second_is ? joint.frame_b : joint.frame_a, second_is ? 1.0 : -1.0});
    }
    for (std::size_t k = 0; k < model.springs.size(); ++k) {
      const spec::Spring& spring = model.springs[k];
      if (!on_body(spring.frame_a) && !on_body(spring.frame_b)) continue;
      const int tension = output("spring_force", static_cast<int>(k), 0);
      const int a = vector_output("position", spring.frame_a),
                b_place = vector_output("position", spring.frame_b);
      if (on_body(spring.frame_a)) springs_.push_back({tension, a, b_place, spring.frame_a});
      if (on_body(spring.frame_b)) springs_.push_back({tension, b_place, a, spring.frame_b});
    }
    for (std::size_t k = 0; k < model.tyres.size(); ++k)
      if (on_body(model.tyres[k].frame))
        tyres_.push_back({output("tyre_force", static_cast<int>(k), 0), model.tyres[k].frame});
  }

  const spec::Model& model() const { return model_; }

  /// Generalised forces on the modes at an instant.
  VectorXd forces(const ResultsRow& row, const spec::Model& original) const {
    const auto pose = row.poses.col(body_);
    const Matrix3d R = Eigen::Quaterniond(pose[3], pose[4], pose[5], pose[6]).toRotationMatrix();
    VectorXd f = VectorXd::Zero(flexible_.modes);
    const auto add = [&](int frame, const FrameWrench& w) {
      const int k = original.frames[static_cast<std::size_t>(frame)].flexible_frame;
      if (k < 0) return;
      const BodyFrame& place = flexible_.frames[static_cast<std::size_t>(k)];
      f += place.X.transpose() * (R.transpose() * w.force) +
           place.X_theta.transpose() * (R.transpose() * w.moment);
    };
    const auto vector = [&](int at) { return Vector3d(row.channels.segment<3>(at)); };
    const auto origin = [&](int frame) {
      return Vector3d(pose.head<3>() + R * original.frames[static_cast<std::size_t>(frame)].pose.position);
    };
    for (const JointForce& j : joints_) {
      FrameWrench w{j.sign * vector(j.at), j.sign * vector(j.at + 3)};
      w.moment += (vector(j.place) - origin(j.frame)).cross(w.force);
      add(j.frame, w);
    }
    for (const SpringForce& s : springs_)
      add(s.frame,
          {row.channels[s.tension] * (vector(s.other) - vector(s.own)).normalized(), Vector3d::Zero()});
    for (const auto& [at, frame] : tyres_)
      add(frame, {row.channels[at] * Vector3d::UnitZ(), Vector3d::Zero()});
    for (const spec::Load& load : original.loads) {
      if (!on_body(load.frame)) continue;
      const Matrix3d axes =
          load.follower ? Matrix3d(R * original.frames[static_cast<std::size_t>(load.frame)].pose.rotation)
                        : Matrix3d::Identity();
      const double scale = load.scale.value(row.time);
      add(load.frame, {scale * (axes * load.force), scale * (axes * load.moment)});
    }
    // Acceleration of the points r of the body, a0 + A r, body axes; gravity acts like its opposite.
    const Vector3d a0 = vector(accelerations_[0]);
    Matrix3d A;
    for (int k = 0; k < 3; ++k)
      A.col(k) = R.transpose() * (vector(accelerations_[static_cast<std::size_t>(k + 1)]) - a0);
    f -= flexible_.S.transpose() * (R.transpose() * (a0 - original.gravity));
    for (int i = 0; i < 3; ++i) f -= flexible_.S_position[static_cast<std::size_t>(i)].transpose() * A.col(i);
    return f;
  }

 private:
  struct JointForce {
    int at, place, frame;
    double sign;
  };
  struct SpringForce {
    int tension, own, other, frame;
  };

  /// Forces on the body that the response would leave out.
  void refuse_what_is_not_followed(const spec::Model& model) const {
    const auto refuse = [](const Mark& mark, const std::string& what) {
      throw InputError(mark,
                       what +
                           " acts on the body, which a selection of modes by the run of a rigid body does "
                           "not follow yet; select them in another way");
    };
    for (const spec::Load& load : model.loads)
      if (load.signal >= 0 && on_body(load.frame))
        refuse(load.mark, "load '" + load.name + "', with a signal,");
    for (const spec::Tyre& t : model.tyres)
      if (t.law != "tyre" && on_body(t.frame)) refuse(t.mark, "tyre '" + t.name + "', which rolls,");
    for (const spec::Element& e : model.elements) {
      const auto touches = [&](int frame) { return frame >= 0 && on_body(frame); };
      if (touches(e.frame_a) || touches(e.frame_b) || std::any_of(e.path.begin(), e.path.end(), touches))
        refuse(e.mark, e.law + " '" + e.name + "'");
    }
    for (const spec::Contact& c : model.contacts)
      for (const spec::Spheres& set : c.spheres)
        if (set.surface_of == body_ ||
            std::any_of(set.frames.begin(), set.frames.end(), [&](int frame) { return on_body(frame); }))
          refuse(c.mark, "contact '" + c.name + "'");
  }

  bool on_body(int frame) const { return model_.frames[static_cast<std::size_t>(frame)].body == body_; }
  int output(const char* kind, int item, int component) {
    spec::Output o;
    o.name = "rigid response " + std::to_string(model_.outputs.size());
    o.kind = kind;
    o.item = item;
    o.component = component;
    model_.outputs.push_back(o);
    return static_cast<int>(model_.outputs.size()) - 1;
  }
  /// Three components; the number of the first.
  int vector_output(const char* kind, int item, int first = 0) {
    const int at = output(kind, item, first);
    output(kind, item, first + 1);
    output(kind, item, first + 2);
    return at;
  }

  spec::Model model_;
  int body_;
  const ReducedBody& flexible_;
  std::array<int, 4> accelerations_{};
  std::vector<JointForce> joints_;
  std::vector<SpringForce> springs_;
  std::vector<std::pair<int, int>> tyres_;
};

/// ÿ + c ẏ + k y = f(t) over the instants, f linear between them; y(0) = start, at rest.
VectorXd oscillator(double c, double k, const VectorXd& time, const VectorXd& f, double start) {
  using Complex = std::complex<double>;
  Complex root = std::sqrt(Complex(0.25 * c * c - k, 0));
  // Equal roots are a limit; beside it nothing is lost but digits.
  if (std::abs(root) < 1e-6 * std::sqrt(k)) root = 1e-6 * std::sqrt(k);
  const Complex a = -0.5 * c + root, b = -0.5 * c - root;
  VectorXd y(time.size());
  double x = start, v = 0;
  y[0] = x;
  for (Index n = 1; n < time.size(); ++n) {
    const double h = time[n] - time[n - 1], slope = (f[n] - f[n - 1]) / h;
    // A particular solution is a line; what is left decays.
    const double rate = slope / k, place = f[n - 1] / k - c * rate / k;
    const double dx = x - place, dv = v - rate;
    const Complex ea = std::exp(a * h), eb = std::exp(b * h);
    const Complex pa = (dv - b * dx) / (a - b), pb = (a * dx - dv) / (a - b);
    x = (pa * ea + pb * eb).real() + place + rate * h;
    v = (pa * a * ea + pb * b * eb).real() + rate;
    y[n] = x;
  }
  return y;
}

}  // namespace

AmplitudeHistory rigid_response(const spec::Model& model, int body, const ModeSelectionOptions& options) {
  const RigidModel rigid(model, body);
  const ReducedBody& b = *model.bodies[static_cast<std::size_t>(body)].flexible;
  std::vector<double> time;
  std::vector<VectorXd> forces;
  record_run(rigid.model(), options, [&](const ResultsRow& row) {
    time.push_back(row.time);
    forces.push_back(rigid.forces(row, model));
  });
  AmplitudeHistory history{Eigen::Map<const VectorXd>(time.data(), static_cast<Index>(time.size())),
                           MatrixXd(b.modes, static_cast<Index>(time.size()))};
  for (int k = 0; k < b.modes; ++k) {
    VectorXd f(history.time.size());
    for (Index n = 0; n < f.size(); ++n) f[n] = forces[static_cast<std::size_t>(n)][k];
    const double stiffness = b.stiffness(k, k) / b.mass_matrix(k, k);
    f /= b.mass_matrix(k, k);
    history.amplitudes.row(k) = oscillator(b.damping(k, k) / b.mass_matrix(k, k), stiffness, history.time, f,
                                           model.simulation.start_at_equilibrium ? f[0] / stiffness : 0.0)
                                    .transpose();
  }
  return history;
}

}  // namespace mimbre
