#pragma once
#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "compile/compiled.h"
#include "dynamics/state.h"
#include "dynamics/state_transfer.h"
#include "mimbre/model.h"
#include "reduction/stiffening/stretching_states.h"

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
/// of its own, which is measured and counts as far as it is of that kind: of the size l_q = ½ yᵀ T y that the
/// nearest rotation of the frames has it, as far as A leaves it. Without the force of that press the linear
/// body would bend by y₀ = y + C Σ_s (A l)_s T_s y, C its compliance between what holds it, and in truth it
/// is stretched by e + l: so y₀, with e + l of y₀, stands for y above. Deflections are too large by the share
/// σ/α − 1, σ the deflection by y over that by y₀, both along the loads K y₀.
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
    double missing = 0;  ///< ρ
    double pressed = 1;  ///< σ
  };
  /// Of each. Neither allocates nor throws.
  const std::vector<Ratios>& find(const double* positions);
  /// σ/α − 1: by how much deflections are too large, below 0 too small.
  static double exaggeration(const Ratios& ratios);
  /// Whether the size of that is more than `most`, at a fraction of the cost.
  static bool exceeds(const Ratios& ratios, double most);

 private:
  /// A body's coordinates and states at most: loops of fixed length over them become vector instructions.
  static constexpr int most_coordinates = 16, most_states = most_stretching_states;
  template <int rows>
  using Rows = Eigen::Matrix<double, rows, Eigen::Dynamic>;  ///< the last ones 0 where there are fewer
  struct Body {
    int first_amplitude = 0, modes = 0, first_state = 0, states = 0, coordinates = 0;
    Rows<most_coordinates> bending;     ///< coordinates of its bending, energy ½ |c|², by amplitudes
    Rows<most_states> stretch;          ///< e by products c_i c_j, j ≤ i, in the order 00, 10, 11, 20 …
    Rows<most_states> turn;             ///< l_q likewise; empty where it does not turn
    Rows<most_states> press;            ///< l by amplitudes
    Rows<most_coordinates> compliance;  ///< C, in these coordinates
    Eigen::MatrixXd unit, axes;  ///< amplitudes by coordinates of unit energy, and those by c: for the start
    std::array<double, most_coordinates> c{};  ///< of y, then of y₀
    double share = 0;                          ///< of l_q that is in l
  };
  struct Ends;
  /// Whether any of the body's states of stress may count; the work of those on the places' motions.
  bool add(const Compiled& model, int number, std::vector<Eigen::MatrixXd>& places);
  void find_held(const Compiled& model, const std::vector<Eigen::MatrixXd>& places);
  void find_coupling(const State& state, const State& inputs);
  /// C, where the mechanism permits `motions` (orthonormal columns) of the coordinates `felt`, and all
  /// others.
  void find_compliance(const Eigen::MatrixXd& motions, const std::vector<Eigen::Index>& felt);
  /// Coordinates, l, and its share of l_q; whether there is any.
  bool find_press(Body& body, const double* amplitudes);
  /// From y to y₀: the body's σ, and e + l there.
  void release(Body& body, Ratios& ratios);

  std::vector<int> numbers_;
  std::vector<Body> bodies_;
  std::unique_ptr<Ends> held_;  ///< with places that can move; none: places do not matter
  int states_ = 0;
  bool slack_ = false;        ///< A is so small that nothing would ever come of it
  Eigen::VectorXd strength_;  ///< the ratio of each state alone at the largest deflection, with A = 1
  Eigen::MatrixXd coupling_;  ///< A
  Eigen::VectorXd stretch_, press_, force_;  ///< e + l, l, and A times one of them
  std::vector<Ratios> ratios_;
};

}  // namespace mimbre
