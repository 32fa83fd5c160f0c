#pragma once
#include <Eigen/Core>
#include <array>

#include "dynamics/state_transfer.h"

namespace mimbre {

/// Finds what the geometric stiffness G that a linear body neglects does to its deflections over time: a
/// vibration that tension makes faster by a few per cent is out of phase after a few periods. With K, C the
/// body's stiffness and damping and D the response of its amplitudes to forces on them, as the mechanism lets
/// them move (at the start of the run), D K ψ = ψ Ω² has the body's slowest modes there. Of amplitudes y
/// these take part by z = ψᵀ K y, ½ |z|² their elastic energy. What y lacks is then e in them,
///
///   Ω⁻² ë + c ė + e + g (e + z) = 0,   c = ψᵀ C ψ, g = ψᵀ G ψ,   e = ė = 0 at the start
///
/// by the trapezoidal rule. The lag is the largest |e| over the range of z.
class Lag {
 public:
  static constexpr int most_modes = 4;
  using Vector = Eigen::Vector4d;
  using Matrix = Eigen::Matrix4d;

  /// The slowest modes of a body with the stiffness K (`amplitudes`: amplitudes × coordinates of unit elastic
  /// energy, from slow ones to fast ones of the body alone), and C. `response`: D.
  void set_modes(const Eigen::MatrixXd& K, const Eigen::MatrixXd& C, const Eigen::MatrixXd& amplitudes,
                 const Eigen::MatrixXd& response);
  bool watched() const { return count_ > 0; }

  /// No error yet, and no stiffness.
  void start(const double* amplitudes, double time);
  /// From now on: Aᵀ G A, A the first columns of `amplitudes`, as many as there are, others 0. Neither
  /// allocates nor throws.
  void stiffen(const Matrix& stiffness);
  /// After a step. Likewise.
  void watch(const double* amplitudes, double time);
  double value() const;
  void transfer(StateTransfer& transfer);

 private:
  Vector read(const double* amplitudes) const;
  bool factor(double h);

  int count_ = 0;                                                 ///< modes
  Eigen::Matrix<double, most_modes, Eigen::Dynamic> rows_;        ///< ψᵀ K
  Matrix own_ = Matrix::Zero();                                   ///< ψ by the first columns of `amplitudes`
  Vector squares_ = Vector::Zero();                               ///< Ω⁻²
  Matrix damping_ = Matrix::Zero(), stiffness_ = Matrix::Zero();  ///< c, g
  Matrix inverse_ = Matrix::Zero();                               ///< (Ω⁻² + c h/2 + (1 + g) h²/4)⁻¹
  double step_ = 0;                                               ///< h of that; 0: of none
  double time_ = 0, largest_ = 0;
  bool lost_ = false;  ///< the error has become as large as anything
  Vector error_ = Vector::Zero(), rate_ = Vector::Zero(), second_ = Vector::Zero();  ///< e, ė, ë
  Vector least_ = Vector::Zero(), most_ = Vector::Zero();                            ///< z so far, and 0
};

}  // namespace mimbre
