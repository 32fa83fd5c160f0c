#pragma once
#include <cmath>
#include <optional>
#include <tuple>

#include "analysis/equilibria/path_equations.h"

/// Equilibria on a path, and how one is found from another.
namespace mimbre {

struct PathPlace {
  State state;
  double factor = 0;
  PathTangent tangent;
  /// Of the stiffness, ascending, in units of what each coordinate resists at the first place; where it is
  /// not symmetric empty.
  Eigen::VectorXd eigenvalues;
  bool symmetric = true;
  int unstable = 0;  ///< eigenvalues with a negative real part
  int negative = 0;  ///< real negative ones
};

/// A direction of the path: along all scaled coordinates, and of the factor by its range.
struct PathDirection {
  Eigen::VectorXd motion;
  double factor = 0;
  double length() const { return std::sqrt(motion.squaredNorm() + factor * factor); }
  double largest() const {
    return std::max(motion.size() == 0 ? 0 : motion.cwiseAbs().maxCoeff(), std::abs(factor));
  }
  double along(const PathDirection& other) const { return motion.dot(other.motion) + factor * other.factor; }
};

class PathPlaces {
 public:
  PathPlaces(PathEquations& equations, double range) : equations_(equations), range_(range) {}

  /// The equations at the place; false where they are not finite.
  bool look(PathPlace& place);
  /// The units of eigenvalues become those of this place.
  void measure(const PathPlace& place);
  /// What the stiffness there says; false where its eigenvalues were not found.
  bool judge(PathPlace& place) const;

  /// The equilibrium in the plane across the direction, `length` along it. Corrections may add up to `reach`
  /// of that length.
  std::optional<PathPlace> ahead(const PathPlace& from, const PathDirection& along, double length,
                                 double reach, int* corrections = nullptr);
  /// That with the factor, near a place; all corrections at most `reach`.
  std::optional<PathPlace> at_factor(const PathPlace& near, double factor, double reach);
  /// The path's tangent, of length one, on the side of `like`. Where several paths cross there, that without
  /// the motions that have no stiffness.
  std::optional<PathDirection> direction(const PathPlace& at, const PathDirection& like) const;

  /// An independent motion, its left vector, and its stiffness in the units of eigenvalues: that of an
  /// eigenvalue by its number, or (-1, or where the stiffness is not symmetric) the softest. Empty: not
  /// found.
  std::tuple<Eigen::VectorXd, Eigen::VectorXd, double> motion(const PathPlace& place, int number = -1) const;
  /// Whether the loads, over their range, do more than round-off on a motion (by its left vector).
  bool works(const PathPlace& place, const Eigen::VectorXd& left) const;
  /// An independent motion that nothing resists; empty: there is none.
  Eigen::VectorXd without_stiffness(const PathPlace& place) const;

 private:
  std::optional<PathPlace> corrected(State state, double factor, const PathDirection& across, double reach,
                                     int* corrections);
  /// [K, load; across] over (y, factor by the range), rows and columns of about one; what to multiply the
  /// forces with, and the solution.
  struct Bordered {
    Eigen::MatrixXd matrix;
    Eigen::VectorXd rows, columns;
  };
  Bordered bordered(const PathTangent& at, const PathDirection& across) const;
  Eigen::VectorXd units(const PathTangent& at) const;

  PathEquations& equations_;
  const double range_;
  Eigen::VectorXd sizes_;  ///< by velocity coordinate: what it resists
};

}  // namespace mimbre
