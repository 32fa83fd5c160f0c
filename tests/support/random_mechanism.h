#pragma once
#include <Eigen/Core>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "compile/compiled.h"
#include "dynamics/relative/system.h"
#include "mimbre/beam_reduction.h"
#include "mimbre/model.h"

/// Random mechanisms for property tests: the same seed gives the same mechanism.
namespace mimbre::test {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Numbers that do not depend on the standard library's distributions.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed * 2654435761u + 12345u) { engine_.discard(8); }
  /// Uniform in [low, high].
  double number(double low, double high) { return low + (high - low) * (engine_() / 4294967295.0); }
  /// Uniform in 0 .. count - 1.
  int index(int count) { return static_cast<int>(engine_() % static_cast<unsigned>(count)); }
  bool chance(double probability) { return number(0, 1) < probability; }
  Vec3d vector(double size);
  Mat3d rotation();
  spec::Pose pose(double size);
  VectorXd values(int count, double size);

 private:
  std::mt19937 engine_;
};

spec::Pose after(const spec::Pose& outer, const spec::Pose& inner);
spec::Pose inverse(const spec::Pose& p);

/// The same body in other modal coordinates: y = mix · y'. Its mass matrix is no longer the identity.
ReducedBody mixed(ReducedBody b, const MatrixXd& mix);

/// A soft bent frame of beams with one clamped node, and four frames: the clamped node's, both ends', and one
/// halfway. Modes: 2 to 6. Half of them in coordinates that are not orthogonal. Made once per kind.
std::shared_ptr<const ReducedBody> random_flexible_body(int kind,
                                                        fe::Stiffening stiffening = fe::Stiffening::linear);

struct RandomOptions {
  int bodies = 5;
  int loops = 0;
  double flexible_share = 0.5;
  fe::Stiffening stiffening = fe::Stiffening::linear;  ///< of the flexible bodies
  bool springs = false;                                ///< elastic ones between frames and on joints
  bool damping = false;                                ///< dampers and modal damping
  bool tyres = false;
  bool loads = false;
  bool drives = false;
  bool gravity = true;
  bool floating = true;  ///< allow floating joints
};

/// A mechanism and a position in which its loops are closed and its drives are at their places.
struct RandomMechanism {
  std::shared_ptr<const Model> model;
  VectorXd q;
  const Compiled& compiled() const { return model->compiled(); }
};

/// Coordinates zero and quaternions of unity: frames of tree joints coincide, no deformation.
VectorXd assembled_position(const Compiled& m);

/// Increments of joint coordinates up to `size`, and of modal ones that move and turn the body's frames by up
/// to about `size / 3` m or rad.
VectorXd random_increment(const Compiled& m, Random& random, double size);

VectorXd random_position(const relative::RelativeSystem& system, Random& random, double size);

/// A tree of bodies with every joint type in turn, forward and reversed, and loops closed by every joint type
/// in turn.
RandomMechanism random_mechanism(unsigned seed, const RandomOptions& options);

}  // namespace mimbre::test
