#pragma once
#include <Eigen/Core>
#include <vector>

#include "dynamics/state_transfer.h"

namespace mimbre {

/// Splits coordinates into dependent and independent ones by the equations Φz x = b, and solves them for the
/// dependent ones (Wehage, Haug 1982; Serna, Avilés, García de Jalón 1982). Redundant equations are set
/// aside. Works on memory made once.
class Partition {
 public:
  Partition(int coordinates, int equations);

  /// Chooses equations and dependent coordinates by Gaussian elimination with complete pivoting of the
  /// Jacobian (equations × coordinates), its rows and columns multiplied by the weights, by which
  /// coefficients are of the order of 1: coordinates of large weight become dependent. The first choice takes
  /// all pivots above 1e-7 of their equation, or of 1e-6 where that has only smaller coefficients, the
  /// round-off of one that holds nothing; later ones take as many, so that equations that are redundant where
  /// the loops are closed stay so while they are a little open. False when that many do not exist, or more
  /// that are not small: the first choice was made, or this one is, at a singular position. weakest() then
  /// returns where.
  bool choose(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& row_weight,
              const Eigen::VectorXd& column_weight);
  /// Factorises the Jacobian of another position with the same choice. False when a pivot has lost its sign
  /// or nine tenths of its size: a singular position is near or was passed; weakest() returns where.
  bool factor(const Eigen::MatrixXd& jacobian);
  int weakest() const { return weakest_; }  ///< equation

  int rank() const { return rank_; }
  /// The rank of the first choice, which all later ones keep.
  void transfer(StateTransfer& transfer) { transfer(rank_); }
  int dependent(int k) const { return coordinate_[k]; }            ///< k < rank
  int independent(int k) const { return coordinate_[rank_ + k]; }  ///< k < coordinates − rank
  int equation(int k) const { return equation_[k]; }               ///< k < rank; the others are redundant

  /// x (coordinates × 1): dependent ones solve Φz x = b (b: one per equation), independent ones are zero.
  void particular(const double* b, double* x);
  /// y: one per equation, (Φzᵀ y) = b in the dependent coordinates, zero for redundant equations.
  void multipliers(const double* b, double* y);
  /// R (coordinates × independent ones): Φz R = 0, R is the identity in the independent coordinates.
  void null_space(Eigen::MatrixXd& R);

 private:
  int n_, m_, rank_ = -1, weakest_ = -1;
  std::vector<int> equation_, coordinate_;  // in the order of elimination
  Eigen::MatrixXd lu_;  // rank × coordinates in that order: L below the diagonal, U above
  Eigen::VectorXd pivot_, largest_, work_;
};

}  // namespace mimbre
