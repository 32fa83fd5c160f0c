#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"

namespace mimbre {

/// Reactions that grow beyond all bounds on the way through a singular position.
struct UnresolvedReaction {
  double time = 0;               ///< s
  int joint = -1;                ///< that carries most, in the model as it was given
  double force = 0, moment = 0;  ///< N, N m
};

/// Of all reactions that balance the bodies, the smallest ones: Σ |f|² + |n|² / L² over all joints, tree or
/// cut, f and n on the second frame, L the model's length scale. They are what joints that are all alike and
/// a little elastic would carry, and do not depend on which joints are cut. Where constraints are not
/// redundant there is nothing to choose.
///
/// Per body the wrenches x of its joints have a given sum, A x = b. The smallest are x = Aᵀ y, A Aᵀ y = b,
/// solved with a small multiple of the diagonal added and again for what is left (proximal point), so that
/// motions of the mechanism, with Aᵀ y = 0, do no harm and those that nearly are motions give no forces.
class SmallestReactions {
 public:
  explicit SmallestReactions(const Compiled& model);
  /// Replaces the multipliers, after the system's residual with them at s. Neither allocates nor throws;
  /// false, and nothing is changed, when the forces cannot be balanced so.
  bool find(const relative::RelativeSystem& system, const State& s, Eigen::VectorXd& multipliers);
  /// Where nearly all that the joints carry is held by motions that strain them by less than `strain` (a
  /// small one: what a step moves, by L), as where a parallelogram goes through its change point: puts the
  /// wrenches that such motions do not concern in the place of the multipliers, and returns what was there.
  /// Else nothing is changed. Call as find().
  std::optional<UnresolvedReaction> limit(const relative::RelativeSystem& system, const State& s,
                                          double strain, Eigen::VectorXd& multipliers);

 private:
  /// Of the wrench that a joint transmits to its second body, what is unknown: a combination of `count` unit
  /// wrenches about the origin of frame b, moments in units of L.
  struct Transmitted {
    int body_a = -1, body_b = -1, frame_a = -1, frame_b = -1;
    int tree = -1, loop = -1;
    double sign = 1;  ///< of the tree body's own wrench on the second body
    int first = 0, count = 0;
    std::ptrdiff_t rows_a = 0, rows_b = 0;  ///< A's blocks, one column after the other
    linalg::BlockPlace aa, ab, bb;
    Vec3d at = Vec3d::Zero();  ///< origin of frame b
    Vec3d force[6], moment[6];
  };
  int size(int body) const { return 6 + model_.bodies[static_cast<std::size_t>(body)].modes; }
  void set_wrenches(const relative::RelativeSystem& system, const State& s,
                    const Eigen::VectorXd& multipliers);
  void set_rows(const relative::RelativeSystem& system, int body, int frame, double sign,
                const Transmitted& t, double* rows);
  void set_amplitudes(const State& s, int body);
  void set_given(const relative::RelativeSystem& system, const State& s, const Eigen::VectorXd& multipliers);
  void set_multipliers(const relative::RelativeSystem& system, Eigen::VectorXd& multipliers) const;
  bool factor(double regularisation);
  double balance(int rounds);
  void add_times(const Eigen::VectorXd& x, double weight, Eigen::VectorXd& out) const;
  void add_transposed_times(const Eigen::VectorXd& y, Eigen::VectorXd& out) const;

  const Compiled& model_;
  std::vector<Transmitted> joints_;
  std::vector<int> drive_;  ///< by velocity coordinate, -1: none
  std::unique_ptr<linalg::BlockSymbolic> symbolic_;
  std::unique_ptr<linalg::BlockFactor<double>> factor_;
  std::vector<linalg::BlockPlace> diagonal_;
  std::vector<Vec3d> centre_;  ///< by body, the mean of its joints' places
  std::vector<int> places_;    ///< how many
  std::vector<double> rows_;
  AlignedVector<double> y_, modal_;
  Eigen::VectorXd given_, x_, change_, left_, solution_;
};

}  // namespace mimbre
