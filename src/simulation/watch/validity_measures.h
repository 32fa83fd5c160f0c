#pragma once
#include <Eigen/Core>
#include <vector>

#include "compile/compiled.h"
#include "mimbre/reduced_body.h"

/// Properties of a reduced body's shape and modes, for judging what its linear description neglects. All is
/// found once, before the first step.
namespace mimbre::validity {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Whether a bracket joins the body to another flexible one.
bool is_piece(const Compiled& model, int body);

/// The points that displacements are known of: the drawing's, or the frames when a file came without.
struct Points {
  Eigen::Matrix3Xd places;
  MatrixXd shapes;  ///< 3·points × modes
};

Points points_of(const ReducedBody& body);

/// The points whose displacements are watched: all where there are few. Otherwise those with most information
/// (each next one moves most for its elastic energy where the ones before it are held, so that a joint that
/// holds the body's end does not hide how its middle bends), and more between them: what is largest elsewhere
/// is a few per cent larger at most.
std::vector<Eigen::Index> telling_points(const Points& points, const MatrixXd& stiffness);

/// Distance between two points that are far apart: the largest one for anything slender.
double extent(const Eigen::Matrix3Xd& places);

/// A line of the drawing, or a side of its triangles, as a bar.
struct Bar {
  int a = 0, b = 0;
  double length = 0;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< from a to b
};

std::vector<Bar> bars_of(const ReducedBody& body);

/// Displacement of end b minus that of end a, 3 × modes.
MatrixXd difference(const ReducedBody& body, const Bar& bar);

MatrixXd across(const Bar& bar, const MatrixXd& u);

/// Mass of each node, kg.
VectorXd node_masses(const ReducedBody& body, const std::vector<Bar>& bars);

/// Which bar leads from each node towards the tangent frame, on the shortest way along the lines, and the
/// nodes by increasing distance from it: how forces flow, exactly so where the lines do not close.
struct Tree {
  std::vector<int> bar;     ///< by node, -1 where the modes vanish
  std::vector<int> parent;  ///< by node
  std::vector<int> order;
};

Tree tree_of(const ReducedBody& body, const std::vector<Bar>& bars);

/// Modes of the reduced matrices with unit modal mass, ascending; those that carry no load are left out.
struct Eigenmodes {
  MatrixXd shapes;   ///< modes × count, amplitudes
  VectorXd squares;  ///< ω²
};

Eigenmodes eigenmodes(const ReducedBody& body);

/// Rows whose values' squares add up to twice the energy in the highest third of the series, of those modes
/// that a mode of half the frequency or less precedes in about the same direction: the first bending mode
/// across is not a high one, however many there are along.
MatrixXd high_rows(const ReducedBody& body);

/// R with Rᵀ R = form, positive semidefinite, without rows that are round-off.
MatrixXd root(const MatrixXd& form);

}  // namespace mimbre::validity
