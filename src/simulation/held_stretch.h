#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "dynamics/state.h"
#include "dynamics/state_transfer.h"
#include "mimbre/model.h"
#include "model/compiled.h"

namespace mimbre {

/// Finds what linear flexible bodies neglect where their ends or edges are held: to bend they would have to
/// stretch (ReducedBody::stretching). With e the second-order stretch of all bodies' states of stress and d
/// the motion of the places that the mechanism leaves free, or holds by springs, that stretch has the energy
///
///   min over d  ½ |e|² + eᵀ D d + ½ dᵀ K d  =  ½ eᵀ A e
///
/// K the stiffness of places, springs and other flexible bodies, at rest, in the position of the start. Of a
/// body whose bending has the energy U, the force that this adds grows as the cube of the deflection: where
/// loads bend the linear body by y, it would bend by αy, with α + ρ α³ = 1 and ρ = (Σ e_s (A e)_s) / U.
///
/// Linear modes that turn the body's held frames against its own axes, as where these turn at a hinge, by θ
/// say, have them ½ θ² L too far apart. Between ends that are held this presses the body back by a stretch l
/// of its own, which is measured and counts as far as it is of that kind, of the size l_q that the nearest
/// rotation of the frames says: in truth the body is stretched by e + l, and the linear one resists as if by
/// l: α + ρ α³ = 1 + λ, with e + l in the place of e in ρ, and λ = (Σ l_s (A l)_s) / U.
class HeldStretch {
 public:
  explicit HeldStretch(const Compiled& model);
  ~HeldStretch();
  HeldStretch(HeldStretch&&) noexcept;

  /// How far the mechanism holds the bodies at this state (State::u and z are those of `inputs`).
  void start(const State& state, const State& inputs);
  void transfer(StateTransfer& transfer);

  /// Bodies that are watched: the tree bodies' numbers.
  const std::vector<int>& bodies() const { return numbers_; }
  struct Ratios {
    double missing = 0;   ///< ρ
    double spurious = 0;  ///< λ
  };
  /// Of each. Neither allocates nor throws.
  const std::vector<Ratios>& find(const double* positions);
  /// 1/α − 1: by how much deflections are too large, below 0 too small.
  static double exaggeration(const Ratios& ratios);

 private:
  struct Body {
    int first_amplitude = 0, modes = 0, first_state = 0, states = 0;
    Eigen::MatrixXd bending;             ///< coordinates of its bending, energy ½ |c|², by amplitudes
    std::vector<Eigen::MatrixXd> forms;  ///< e_s = ½ cᵀ form c
    std::vector<Eigen::MatrixXd> turns;  ///< the same of l_q; none where it does not turn
    Eigen::MatrixXd linear;              ///< l by amplitudes
    Eigen::VectorXd c, product, stretch, turned, pressed;
  };
  struct Held;
  /// Whether any of the body's states of stress may count; the work of those on the places' motions.
  bool add(const Compiled& model, int number, std::vector<Eigen::MatrixXd>& places);
  void find_held(const Compiled& model, const std::vector<Eigen::MatrixXd>& places);
  void find_coupling(const State& state, const State& inputs);

  std::vector<int> numbers_;
  std::vector<Body> bodies_;
  std::unique_ptr<Held> held_;  ///< with places that can move; none: places do not matter
  int states_ = 0;
  bool slack_ = false;        ///< A is so small that nothing would ever come of it
  Eigen::VectorXd strength_;  ///< the ratio of each state alone at the largest deflection, with A = 1
  Eigen::MatrixXd coupling_;  ///< A
  Eigen::VectorXd stretch_, turned_, force_;
  std::vector<Ratios> ratios_;
};

}  // namespace mimbre
