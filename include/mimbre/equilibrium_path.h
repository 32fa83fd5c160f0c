#pragma once
#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/channels.h"
#include "mimbre/model.h"

/// Equilibria of a mechanism under loads that grow: what becomes of it beyond buckling.
namespace mimbre {

struct EquilibriumPathOptions {
  /// Loads that grow together; none: all of the model, or its weight where it has none. The others keep their
  /// values.
  std::vector<std::string> loads;
  double from = 0, to = 1;               ///< factors of these loads: the path's first, and its last
  int most_points = 200;                 ///< of each branch
  int bifurcations = 1;                  ///< whose branches are followed, at most
  std::map<std::string, double> inputs;  ///< RunOptions::inputs
  /// Called at each point with the factor, and the number of points so far. What it throws ends the search.
  std::function<void(double factor, int points)> progress;
};

/// An equilibrium on a path.
struct PathPoint {
  enum class Kind {
    regular,
    limit,       ///< the factor is largest or smallest here: beyond, the mechanism snaps
    bifurcation  ///< another path crosses here
  };
  double factor = 0;       ///< of the loads
  Eigen::VectorXd values;  ///< of the channels
  /// Independent directions along which the tangent stiffness is negative: 0 where the equilibrium is stable;
  /// of loads without a potential the eigenvalues with a negative real part, which flutter may precede. At
  /// limits and bifurcations without the one that vanishes.
  int unstable = 0;
  Kind kind = Kind::regular;
  std::string moving;  ///< of a limit or a bifurcation: coordinates with their shares of the motion there
};

/// By PathPoint::Kind.
inline constexpr const char* path_point_words[] = {"", "limit", "bifurcation"};

struct PathBranch {
  int parent = -1;       ///< the branch that it leaves, -1: none
  double leaves_at = 0;  ///< factor there
  int sense = 0;         ///< 1: along the motion at the bifurcation, -1: against it, 0: leaves none
  std::vector<PathPoint> points;
  std::string end;  ///< why there are no more
};

struct EquilibriumPath {
  std::vector<std::string> loads;     ///< that grow: names, or "gravity"
  std::vector<ChannelInfo> channels;  ///< the model's outputs first
  int output_count = 0;
  std::vector<PathBranch> branches;  ///< the first begins at the equilibrium with the first factor
  std::vector<std::string> warnings;
  double cpu_seconds = 0;
};

/// Follows the equilibria g(y, λ) = 0 in minimal coordinates from that at the first factor λ, around limit
/// points and through bifurcations: predictor along the tangent, corrector in the plane across it (Riks, J.
/// Appl. Mech. 39, 1972; Keller 1977), with exact stiffness. Arc length is measured by the mechanism's scales
/// of coordinates, and by the range of factors. Where an eigenvalue of the stiffness changes its sign the
/// point in between is sought: a limit if the loads work on that motion, otherwise a bifurcation, whose
/// branches begin along that motion, in both senses.
/// Throws InputError and UnknownName for unknown loads, a model without loads and weight, or factors that are
/// no range; std::runtime_error where there is no equilibrium at the first factor or something moves there
/// without resistance (it is named).
EquilibriumPath equilibrium_path(const std::shared_ptr<const Model>& model,
                                 const EquilibriumPathOptions& options = {});

/// The channels that people look at: the model's outputs; coordinates of joints where it has none.
std::vector<int> shown_channels(const EquilibriumPath& path);

/// A line for each point: branch, factor, unstable directions, "limit" or "bifurcation", the shown channels.
/// Until the file is whole an older one stands. Throws std::runtime_error, with the path, when it cannot be
/// written.
void write_csv(const EquilibriumPath& path, const std::string& file);

}  // namespace mimbre
