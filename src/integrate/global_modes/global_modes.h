#pragma once
#include <utility>
#include <vector>

#include "integrate/global_modes/loop_table.h"
#include "integrate/global_modes/loops.h"
#include "integrate/newton.h"
#include "integrate/step_motion.h"
#include "math/once/decompositions.h"

namespace mimbre {

/// Global modal parameterisation (Brüls, Duysinx, Golinval 2007): the coordinates of each loop are functions
/// of one of them, θ, and of the amplitudes δ of modes of the whole loop, tabulated before the first step
/// (global_modes::LoopTable); coordinates that are in no loop stay as they are. With y all of these,
/// v = Z ẏ, a step solves Zᵀ (M a − Q) = 0 for y: no equations, projections and multipliers, and a matrix as
/// small as y. Forces and inertia are evaluated in full.
class GlobalModesStepper final : public Stepper {
 public:
  GlobalModesStepper(System& system, const IntegratorOptions& options);
  /// Makes the tables. Throws global_modes::NoGlobalModes.
  bool prepare(const State& state) override;
  StepStatus step(State& state) override;
  void begun(State& s) const override { motion_.begun(s); }
  void set_step(double step) override;
  void transfer_matrix(StateTransfer& transfer) override;
  void forget() override { kept_ = false; }

 private:
  /// A loop, and where θ and δ are in y.
  struct OfLoop {
    global_modes::LoopMotion motion;
    int first = 0;
  };
  struct OfDrive {
    global_modes::Prescribed at;
    int y = 0;
  };

  /// Coordinates of a diagonal block of the matrix: those of a loop, θ first, or all that are in none.
  struct Part {
    std::vector<int> coordinates;
    global_modes::LoopMotion* motion = nullptr;
    Eigen::MatrixXd Z;  ///< of a loop: of θ, and of all that follows
    int first = 0;      ///< in y
  };

  void choose_parts();
  void multiply(const Part& left, const Part& right);
  void read_start(const State& s);
  int find_off_table(const State& s) const;
  void predict();
  /// Rates and accelerations of y by the rule (`driven`: but for prescribed ones, which have theirs), and all
  /// positions, velocities and accelerations. False: outside of a table.
  bool expand(const State& s, bool driven, StepStatus& status);
  void follow_drives(const State& s);
  void refactor(StepStatus& status);
  bool correct(StepStatus& status);
  void reduce();
  void accept(State& s);

  System& system_;
  StepMotion motion_;
  MatrixWeights weights_;
  std::vector<global_modes::LoopTable> tables_;
  std::vector<OfLoop> loops_;
  std::vector<OfDrive> drives_;
  std::vector<int> free_;         ///< velocity coordinates of the first entries of y
  std::vector<char> prescribed_;  ///< by entry of y
  bool prepared_ = false;
  int size_ = 0;                                               ///< of y
  Eigen::VectorXd start_v_, start_a_, start_w_, start_delta_;  ///< of y; δ by entry of y, θ too
  Eigen::VectorXd y_;                                          ///< θ and δ at the end
  Eigen::VectorXd x_, v_, a_, w_;  ///< increment of y, its rates, accelerations, what the rule carries over
  Eigen::VectorXd r_, reduced_, delta_, none_, full_;
  Eigen::MatrixXd f_, matrix_;
  std::vector<Part> parts_;
  std::vector<std::pair<std::size_t, std::size_t>> coupled_;
  Eigen::VectorXd work_, column_;
  PivotedCholesky factor_;
  bool kept_ = false;       ///< the matrix is one of an earlier step,
  double matrix_step_ = 0;  ///< of this length
};

}  // namespace mimbre
