#include "reduction/stiffening/stretching.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "fe/elements/cell_view.h"
#include "fe/solve/symmetric_solver.h"
#include "math/once/decompositions.h"
#include "math/rotation.h"
#include "reduction/stiffening/stretching_states.h"

namespace mimbre {

namespace fe {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Of the largest state's energy: the states that are kept have more.
constexpr double least_share = 1e-4;
/// Cells that are computed in parallel before any is added: sums do not depend on the number of threads.
constexpr int bunch = 512;
/// Of the energy that the displacements of second order have with nothing in response: round-off.
constexpr double negligible_energy = 1e-9;

using Pairs = std::vector<std::pair<Index, Index>>;

Pairs pairs_of(Index count) {
  Pairs pairs;
  for (Index a = 0; a < count; ++a)
    for (Index b = 0; b <= a; ++b) pairs.emplace_back(a, b);
  return pairs;
}

/// What the cells of a mesh see of fields over its dofs.
class Cells {
 public:
  explicit Cells(const StretchedMesh& s) : s_(s), cells_(mesh_cells(s.mesh)), threads_(hardware_threads()) {
    if (!s.mesh.beams.empty()) beams_ = {s.mesh.nodes, s.mesh.beams};
  }
  int size() const { return cells_.size(); }
  TurningCell cell(int number) const { return s_.cell(cells_, beams_, number); }
  CellView view(int number) const { return fe::view(s_.mesh, cells_, number); }
  template <class Body>
  void in_parallel(int count, const Body& body) const {
    parallel_ranges(even_bounds(count, std::min(count, threads_)), [&](int from, int to) {
      for (int k = from; k < to; ++k) body(k);
    });
  }
  Index row(int node) const { return s_.first_dof[static_cast<std::size_t>(node)]; }
  /// A cell's own dofs in the fields.
  MatrixXd own(int number, const TurningCell& cell, const MatrixXd& fields) const {
    const CellView at = view(number);
    MatrixXd u(cell.node_dofs * at.node_count, fields.cols());
    for (int k = 0; k < at.node_count; ++k)
      u.middleRows(cell.node_dofs * k, cell.node_dofs) = fields.middleRows(row(at.nodes[k]), cell.node_dofs);
    return cell.to_own.size() > 0 ? MatrixXd(cell.to_own * u) : u;
  }

 private:
  const StretchedMesh& s_;
  MeshCells cells_;
  Mesh beams_;
  int threads_;
};

/// Displacements of second order that the nodes of rigid parts have beyond the linear ones, by pairs.
MatrixXd of_rigid_parts(const StretchedMesh& s, const Pairs& pairs) {
  MatrixXd out = MatrixXd::Zero(s.shapes.rows(), static_cast<Index>(pairs.size()));
  for (const RigidNodes& part : s.rigid) {
    const Matrix3Xd turn = part.turn * s.lowest;
    for (const int node : part.nodes) {
      const Vector3d r = s.mesh.nodes.col(node) - part.centre;
      for (std::size_t p = 0; p < pairs.size(); ++p) {
        const Vector3d a = turn.col(pairs[p].first), b = turn.col(pairs[p].second);
        out.col(static_cast<Index>(p)).segment<3>(s.first_dof[static_cast<std::size_t>(node)]) =
            0.25 * (a.cross(b.cross(r)) + b.cross(a.cross(r)));
      }
    }
  }
  return out;
}

/// With which the elements resist displacements of second order.
struct Resistance {
  MatrixXd forces;  ///< dofs × pairs
  MatrixXd energy;  ///< pairs square: twice the energy
};

Resistance resistance(const StretchedMesh& s, const Cells& cells, const Pairs& pairs, const MatrixXd& rigid) {
  const MatrixXd fields = s.shapes * s.lowest;
  const auto count = static_cast<Index>(pairs.size());
  Resistance out{MatrixXd::Zero(s.shapes.rows(), count), MatrixXd::Zero(count, count)};
  std::vector<MatrixXd> forces(bunch), energies(bunch);
  for (int begin = 0; begin < cells.size(); begin += bunch) {
    const int size = std::min(bunch, cells.size() - begin);
    cells.in_parallel(size, [&](int k) {
      const TurningCell cell = cells.cell(begin + k);
      const MatrixXd u = cells.own(begin + k, cell, fields), m = motions(cell, u);
      MatrixXd second =
          s.rigid.empty() ? MatrixXd(MatrixXd::Zero(cell.dofs(), count)) : cells.own(begin + k, cell, rigid);
      for (Index p = 0; p < count; ++p)
        second.col(p) += second_order(cell, u, m, pairs[static_cast<std::size_t>(p)].first,
                                      pairs[static_cast<std::size_t>(p)].second);
      const MatrixXd resisting = cell.stiffness * second;
      const auto at = static_cast<std::size_t>(k);
      energies[at].noalias() = second.transpose() * resisting;
      if (cell.to_own.size() > 0)
        forces[at].noalias() = cell.to_own.transpose() * resisting;
      else
        forces[at] = resisting;
    });
    for (int k = 0; k < size; ++k) {
      const CellView at = cells.view(begin + k);
      for (int node = 0; node < at.node_count; ++node)
        out.forces.middleRows(cells.row(at.nodes[node]), at.node_dofs()) +=
            forces[static_cast<std::size_t>(k)].middleRows(at.node_dofs() * node, at.node_dofs());
      out.energy += energies[static_cast<std::size_t>(k)];
    }
  }
  return out;
}

/// Combinations of the pairs (columns) of unit energy, in the response to them.
MatrixXd states_of(const Resistance& resisted, const MatrixXd& response) {
  MatrixXd energy = resisted.energy + resisted.forces.transpose() * response;
  energy = (0.5 * (energy + energy.transpose())).eval();
  const EigenPairs pairs = symmetric_eigen(energy);
  const Index all = pairs.values.size();
  const double largest = all > 0 ? pairs.values[all - 1] : 0,
               least =
                   std::max(least_share * largest, negligible_energy * resisted.energy.diagonal().maxCoeff());
  Index kept = 0;
  while (pairs.ok && kept < std::min(all, Index{most_stretching_states}) &&
         pairs.values[all - 1 - kept] > least)
    ++kept;
  return pairs.vectors.rightCols(kept) * pairs.values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
}

/// Adds the forms of all cells by the states' displacements of second order: those of the pairs, by `states`,
/// and `further` ones.
void add_forms(const StretchedMesh& s, const Cells& cells, const Pairs& pairs, const MatrixXd& states,
               const MatrixXd& further, const MatrixXd& all_fields, std::vector<MatrixXd>& forms) {
  const MatrixXd fields = s.shapes * s.lowest;
  constexpr Index of_bar = 7, of_other = 3;  // rows of a cell
  MatrixXd left(of_bar * std::min(bunch, cells.size()), all_fields.cols());
  std::vector<MatrixXd> right(forms.size(), left);
  for (int begin = 0; begin < cells.size(); begin += bunch) {
    const int size = std::min(bunch, cells.size() - begin);
    std::vector<Index> first{0};
    for (int k = 0; k < size; ++k)
      first.push_back(first.back() + (cells.view(begin + k).group == nullptr ? of_bar : of_other));
    cells.in_parallel(size, [&](int k) {
      const TurningCell cell = cells.cell(begin + k);
      const MatrixXd low = cells.own(begin + k, cell, fields), low_motions = motions(cell, low);
      MatrixXd pair(cell.dofs(), states.rows());
      for (Index p = 0; p < pair.cols(); ++p)
        pair.col(p) = second_order(cell, low, low_motions, pairs[static_cast<std::size_t>(p)].first,
                                   pairs[static_cast<std::size_t>(p)].second);
      const MatrixXd forces = cell.stiffness * (pair * states + cells.own(begin + k, cell, further));
      const MatrixXd u = cells.own(begin + k, cell, all_fields), m = motions(cell, u);
      const Index at = first[static_cast<std::size_t>(k)];
      left.middleRows(at, m.rows()) = m;
      for (Index state = 0; state < states.cols(); ++state)
        right[static_cast<std::size_t>(state)].middleRows(at, m.rows()) =
            work_partner(cell, forces.col(state), u, m);
    });
    cells.in_parallel(static_cast<int>(states.cols()), [&](int state) {
      forms[static_cast<std::size_t>(state)].noalias() +=
          left.topRows(first.back()).transpose() *
          right[static_cast<std::size_t>(state)].topRows(first.back());
    });
  }
}

/// The modes, then the whole mesh turned about the body's axes.
MatrixXd with_rotations(const StretchedMesh& s) {
  MatrixXd out = MatrixXd::Zero(s.shapes.rows(), s.shapes.cols() + 3);
  out.leftCols(s.shapes.cols()) = s.shapes;
  for (std::size_t node = 0; node < s.first_dof.size(); ++node) {
    const Index at = s.first_dof[node];
    if (at < 0) continue;
    out.block<3, 3>(at, s.shapes.cols()) = -skew<double>(s.mesh.nodes.col(static_cast<Index>(node)));
    Index next = out.rows();
    for (std::size_t k = node + 1; k < s.first_dof.size() && next == out.rows(); ++k)
      if (s.first_dof[k] >= 0) next = s.first_dof[k];
    if (next - at == 6) out.block<3, 3>(at + 3, s.shapes.cols()).setIdentity();
  }
  return out;
}

}  // namespace

MatrixXd lowest_amplitudes(const ReducedBody& body, Index count) {
  if (body.modes == 0) return MatrixXd(0, 0);
  const EigenPairs pairs = symmetric_eigen(body.stiffness, body.mass_matrix);
  const Index all = pairs.values.size();
  Index free = 0;
  while (free < all && !(pairs.values[free] > 1e-12 * pairs.values[all - 1])) ++free;
  count = std::min(count, all - free);
  return pairs.vectors.middleCols(free, count) *
         pairs.values.segment(free, count).cwiseSqrt().cwiseInverse().asDiagonal();
}

std::optional<Stretching> find_stretching(const StretchedMesh& s, std::vector<int> place_of_frame) {
  if (s.lowest.cols() == 0) return {};
  const Cells cells(s);
  const Pairs pairs = pairs_of(s.lowest.cols());
  const MatrixXd rigid = of_rigid_parts(s, pairs);
  const Resistance resisted = resistance(s, cells, pairs, rigid);
  const MatrixXd response = -s.respond(resisted.forces);
  const MatrixXd states = states_of(resisted, response);
  if (states.cols() == 0) return {};

  Stretching out;
  const Index columns = s.shapes.cols() + 3;
  out.forms.assign(static_cast<std::size_t>(states.cols()), MatrixXd::Zero(columns, columns));
  add_forms(s, cells, pairs, states, (rigid + response) * states, with_rotations(s), out.forms);
  // The forces that hold the places, and what they do on rigid parts as these turn.
  const MatrixXd holding = resisted.forces * states + symmetric_times(s.stiffness, response * states);
  out.places = holding.transpose() * s.unit_motions;
  for (Index state = 0; state < states.cols(); ++state) {
    MatrixXd& form = out.forms[static_cast<std::size_t>(state)];
    form = (form + form.transpose()).eval();
    for (const RigidNodes& part : s.rigid) {
      Matrix3Xd forces(3, part.nodes.size()), arms(3, part.nodes.size());
      for (std::size_t k = 0; k < part.nodes.size(); ++k) {
        const auto node = static_cast<std::size_t>(part.nodes[k]);
        forces.col(static_cast<Index>(k)) = holding.col(state).segment<3>(s.first_dof[node]);
        arms.col(static_cast<Index>(k)) = s.mesh.nodes.col(part.nodes[k]) - part.centre;
      }
      MatrixXd turn(3, columns);
      turn << part.turn, Eigen::Matrix3d::Identity();
      form += turn.transpose() * turning_work(forces, arms) * turn;
    }
  }
  out.stiffness.setZero(s.unit_motions.cols(), s.unit_motions.cols());
  if (s.unit_motions.cols() > 6) {  // one place alone moves the body as a whole
    const MatrixXd moved = symmetric_times(s.stiffness, s.unit_motions),
                   resisting = s.unit_motions.transpose() * moved - moved.transpose() * s.respond(moved);
    out.stiffness = 0.5 * (resisting + resisting.transpose());
  }
  out.place_of_frame = std::move(place_of_frame);
  return out;
}

}  // namespace fe
}  // namespace mimbre
