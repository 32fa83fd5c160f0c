#pragma once
#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "integrate/global_modes/spline.h"

/// A loop whose motion is a function of few coordinates.
namespace mimbre::global_modes {

/// How a loop moves with its parameter θ, a joint coordinate, and with amplitudes δ of its global modes:
///   joint coordinates  z = ζ(θ) + Ψz(θ) δ,  modal amplitudes of its bodies  e = Ψe(θ) δ,
/// where ζ closes the loop of rigid bodies and Φz (Ψz, Ψe) = 0 holds at every place of the table. Of
/// rotations ζ is a quaternion, which Ψz δ turns in the body. δ = `measure` e at all θ.
struct LoopTable {
  int coordinate = 0, position = 0;              ///< θ: velocity coordinate, and where it is in q
  double turn = 0;                               ///< θ after which all repeats; 0: never
  std::vector<int> plain, plain_position;        ///< other joint coordinates, and where they are in q
  std::vector<double> per_turn;                  ///< by which they increase in a turn
  std::vector<int> rotation, rotation_position;  ///< first velocity coordinates; quaternions
  std::vector<int> amplitude, amplitude_position;
  int modes = 0;            ///< δ
  Eigen::MatrixXd measure;  ///< modes × amplitudes
  Eigen::MatrixXd shapes;   ///< Ψe where it is the same at all θ, amplitudes × modes; otherwise empty
  /// Columns: ζ (plain, then quaternions), Ψz by mode (plain, then rotations), Ψe by mode unless `shapes`.
  Spline spline;
  double violation = 0;  ///< the largest of Φ between the places of the table, by the scales of the equations

  int joints() const { return static_cast<int>(plain.size() + 3 * rotation.size()); }
  /// Velocity coordinates of the joints but θ, in the order of the rows of Ψz.
  std::vector<int> joint_coordinates() const;
  /// So many velocity coordinates follow: those of joints, then amplitudes.
  int followers() const { return joints() + static_cast<int>(amplitude.size()); }
  /// θ inside the table.
  bool holds(double theta) const {
    return turn > 0 ? std::abs(theta) < 1e9 : theta >= spline.first() && theta <= spline.last();
  }
};

/// The motion of a loop by its table. Allocates only when made.
class LoopMotion {
 public:
  explicit LoopMotion(const LoopTable& table);

  const LoopTable& table() const { return table_; }
  /// θ and δ of positions; θ̇ and δ̇ of velocities, likewise of accelerations and increments.
  double parameter(const double* q) const { return q[table_.position]; }
  void amplitudes(const double* q, double* delta) const;
  void amplitude_rates(const double* v, double* delta_dot) const;

  /// Positions of the loop's coordinates, and Z, by which velocities go.
  void move(double theta, const double* delta, double* q);
  /// v = Z (θ̇, δ̇). `rates`: 1 + modes.
  void velocities(const double* rates, double* v);
  /// a = Z (θ̈, δ̈) + Ż (θ̇, δ̇).
  void accelerations(const double* rates, const double* second, double* a);
  /// out = Zᵀ r, 1 + modes.
  void project(const double* r, double* out);
  /// ∂v/∂(θ̇, δ̇) of the coordinate rows()[row], followers() × (1 + modes); the column of θ first.
  const Eigen::MatrixXd& Z() const { return Z_; }
  /// Velocity coordinates of the rows of Z.
  const std::vector<int>& rows() const { return rows_; }

 private:
  void measured(const std::vector<int>& at, const double* x, double* delta) const;

  const LoopTable& table_;
  std::vector<int> rows_;
  Eigen::VectorXd value_, rate_, second_;  ///< of the table's columns
  Eigen::VectorXd delta_;
  Eigen::MatrixXd Z_;
  Eigen::VectorXd bias_, turned_, turn_rate_, turn_second_, sums_;
};

}  // namespace mimbre::global_modes
