#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "fe/elements/mass_points.h"
#include "fe/node_label.h"
#include "fe/solve/block_lanczos.h"
#include "fe/surface.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_reduce.h"
#include "reduction/bases/attachment.h"
#include "reduction/bases/effective_mass.h"
#include "reduction/bases/free_interface.h"
#include "reduction/bases/independent_shapes.h"
#include "reduction/bases/krylov.h"
#include "reduction/bases/load_modes.h"
#include "reduction/bases/rigid_shapes.h"
#include "reduction/bases/shapes.h"
#include "reduction/bases/user_modes.h"
#include "reduction/connected_parts.h"
#include "reduction/constrained_model.h"
#include "reduction/matrix_checks.h"
#include "reduction/nodal_shape_integrals.h"
#include "reduction/point_integrals.h"
#include "reduction/stiffening/given_stress.h"
#include "reduction/stiffening/solid_stiffening.h"
#include "reduction/stiffening/stretching.h"
#include "reduction/tied_model.h"

namespace mimbre::fe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::SparseMatrix;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kDrawnNodes = 1500;
constexpr double kHertz = 1 / (2 * std::numbers::pi);

/// m_kl of the translations: a third of the trace of each pair's block; full storage.
SparseMatrix<double> nodal_mass_of(const SolidMesh& mesh, const FeMatrices& matrices) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(2 * matrices.mass.nonZeros() / 3));
  for (Index c = 0; c < matrices.mass.cols(); ++c) {
    const Dof& b = matrices.dofs[static_cast<std::size_t>(c)];
    for (SparseMatrix<double>::InnerIterator it(matrices.mass, c); it; ++it) {
      const Dof& a = matrices.dofs[static_cast<std::size_t>(it.row())];
      if (a.direction != b.direction || a.direction > 2) continue;
      entries.emplace_back(a.node, b.node, it.value() / 3);
      if (it.row() != c) entries.emplace_back(b.node, a.node, it.value() / 3);
    }
  }
  SparseMatrix<double> mass(mesh.nodes.cols(), mesh.nodes.cols());
  mass.setFromTriplets(entries.begin(), entries.end());
  return mass;
}

MatrixXd node_shapes(const SolidMesh& mesh, const FeMatrices& matrices, const MatrixXd& shapes) {
  MatrixXd out = MatrixXd::Zero(3 * mesh.nodes.cols(), shapes.cols());
  for (std::size_t r = 0; r < matrices.dofs.size(); ++r)
    if (const Dof& dof = matrices.dofs[r]; dof.direction < 3)
      out.row(3 * dof.node + dof.direction) = shapes.row(static_cast<Index>(r));
  return out;
}

/// The surface with its motion, stress and strain by the modes.
void add_surface(const SolidMesh& mesh, const FeMatrices& matrices, const MatrixXd& shapes,
                 const MatrixXd& displacements, const StressMatrix& stress, ReducedBody& body) {
  Surface seen = surface(mesh);
  const bool given = !stress.nodes.empty();
  if (given) seen = at_nodes(stress, seen);
  if (seen.points.empty())  // matrices alone: a cloud of points
    for (Index k = 0; k < mesh.nodes.cols(); k += 1 + mesh.nodes.cols() / kDrawnNodes)
      seen.points.push_back({static_cast<int>(k), Vector3d::Zero()});
  const auto count = static_cast<Index>(seen.points.size());
  body.nodes.resize(3, count);
  body.node_shapes.resize(3 * count, shapes.cols());
  std::unordered_map<int, std::vector<Index>> on_shell;  // points beside a node
  for (Index k = 0; k < count; ++k) {
    const auto& [node, offset] = seen.points[static_cast<std::size_t>(k)];
    body.nodes.col(k) = mesh.nodes.col(node) + offset;
    body.node_shapes.middleRows<3>(3 * k) = displacements.middleRows<3>(3 * node);
    if (!offset.isZero(0)) on_shell[node].push_back(k);
    if (!mesh.labels.empty()) body.node_labels.push_back(mesh.labels[static_cast<std::size_t>(node)]);
  }
  if (!on_shell.empty())
    for (std::size_t r = 0; r < matrices.dofs.size(); ++r) {
      const auto [node, direction] = matrices.dofs[r];
      const auto found = on_shell.find(node);
      if (direction < 3 || found == on_shell.end()) continue;
      for (const Index k : found->second) {
        const Vector3d arm =
            Vector3d::Unit(direction - 3).cross(seen.points[static_cast<std::size_t>(k)].offset);
        body.node_shapes.middleRows<3>(3 * k) += arm * shapes.row(static_cast<Index>(r));
      }
    }
  body.lines = std::move(seen.lines);
  body.triangles = std::move(seen.triangles);
  const Vector3d size = body.nodes.rowwise().maxCoeff() - body.nodes.rowwise().minCoeff();
  body.line_radius = std::max(1e-6, 1e-3 * size.maxCoeff());
  if (given) {
    body.stress = stress.matrix * shapes;
    return;
  }
  const bool known = std::all_of(mesh.groups.begin(), mesh.groups.end(),
                                 [](const ElementGroup& g) { return g.nodes.empty() || g.material >= 0; });
  if (!known || body.triangles.empty()) return;  // matrices of another program, elements only for the eye
  try {
    Recovery recovery = recover(mesh, seen.points, matrices.dofs, shapes);
    body.stress = std::move(recovery.stress);
    body.strain = std::move(recovery.strain);
  } catch (const std::invalid_argument& error) {
    // The matrices are another program's, and of its elements only the stress would come from here.
    body.checks.push_back({"stress", true, fmt::format("not known: {}", error.what())});
  }
}

/// Stiffness plus `shift` times the mass. Rotations of an interface's nodes that have neither get a
/// stiffness: it touches nothing else.
SparseMatrix<double> shifted(const FeMatrices& matrices, double shift) {
  constexpr double nothing = 1e-15;
  SparseMatrix<double> sum = matrices.stiffness + shift * matrices.mass;
  const VectorXd mass = matrices.mass.diagonal(), stiffness = matrices.stiffness.diagonal();
  const double largest = stiffness.maxCoeff();
  for (Index row = 0; row < sum.rows(); ++row)
    if (mass[row] == 0 && std::abs(stiffness[row]) <= nothing * largest) sum.coeffRef(row, row) += largest;
  return sum;
}

/// Elastic modes of the free model, and how well the reduced body has them.
void add_free_modes(const FeMatrices& matrices, const ModelReduction& options, const MatrixXd& R,
                    const MatrixXd& shapes, double scale, ReductionResult& result) {
  const int count = static_cast<int>(std::min<Index>(options.free_modes, matrices.stiffness.rows() - 6));
  if (count <= 0) return;
  const double shift = 0.3 * scale;
  Pencil pencil;
  pencil.size = matrices.stiffness.rows();
  pencil.shift = -shift;
  const LargeFactor factor(
      shifted(matrices, shift),
      "stiffness plus mass is not positive definite: the matrices are not those of an elastic body");
  pencil.solve = [&](const MatrixXd& b) { return factor.solve(b); };
  pencil.mass = [&](const MatrixXd& x) { return symmetric_times(matrices.mass, x); };
  const Modes full = block_lanczos(pencil, count + 6, [&](double done) {
    if (options.progress) options.progress("free modes", done);
  });
  result.free_frequencies = full.eigenvalues.tail(count).cwiseMax(0).cwiseSqrt() * kHertz;

  MatrixXd all(shapes.rows(), 6 + shapes.cols());
  all << R, shapes;
  const MatrixXd momenta = symmetric_times(matrices.mass, all);
  MatrixXd mass = all.transpose() * momenta,
           stiffness = all.transpose() * symmetric_times(matrices.stiffness, all);
  mass = (0.5 * (mass + mass.transpose())).eval();
  stiffness = (0.5 * (stiffness + stiffness.transpose())).eval();
  // Scaled, so that metres and radians do not meet.
  const VectorXd unit = mass.diagonal().cwiseSqrt().cwiseInverse();
  const EigenPairs reduced = symmetric_eigen(unit.asDiagonal() * stiffness * unit.asDiagonal(),
                                             unit.asDiagonal() * mass * unit.asDiagonal());
  const Index elastic = std::min<Index>(count, shapes.cols());
  result.reduced_free_frequencies = reduced.values.segment(6, elastic).cwiseMax(0).cwiseSqrt() * kHertz;
  const MatrixXd likeness = full.vectors.transpose() * (momenta * (unit.asDiagonal() * reduced.vectors));
  double worst_frequency = 0, worst_mac = 1;
  Index compared = 0;
  std::string rows;
  double trusted = 0;  // Hz, of the last mode before the first that is off
  bool all_agree = true;
  for (Index k = 0; k < elastic; ++k) {
    // Of frequencies that coincide the shapes may be any of their plane: the best of the neighbours together.
    double mac = 0;
    for (Index j = 6; j < reduced.vectors.cols(); ++j) {
      const double f = std::sqrt(std::max(0.0, reduced.values[j])) * kHertz;
      if (std::abs(f / result.reduced_free_frequencies[k] - 1) < 0.02) mac += std::pow(likeness(6 + k, j), 2);
    }
    const double error = result.reduced_free_frequencies[k] / result.free_frequencies[k] - 1;
    rows += fmt::format("{}{:.5g} Hz: {:+.2g} %, MAC {:.4f}", k ? "; " : "", result.free_frequencies[k],
                        100 * error, std::min(mac, 1.0));
    all_agree = all_agree && std::abs(error) < 0.1 && mac > 0.9;
    if (all_agree) trusted = result.free_frequencies[k];
    // The lower half is what the basis is for.
    if (2 * k < elastic) {
      worst_frequency = std::max(worst_frequency, std::abs(error));
      worst_mac = std::min(worst_mac, mac);
      ++compared;
    }
  }
  const bool held = std::any_of(options.interfaces.begin(), options.interfaces.end(), [](const Interface& i) {
    return std::find(i.motions.begin(), i.motions.end(), Interface::Motion::held) != i.motions.end();
  });
  if (held) {
    result.body.checks.push_back({"free frequencies", true,
                                  "not compared: motions that are held make the body stiffer than the full "
                                  "model, as the mechanism must"});
    return;
  }
  const std::string trust = trusted > 0   ? fmt::format("to be trusted up to {:.5g} Hz", trusted)
                            : elastic > 0 ? "not even the first mode is to be trusted"
                                          : "no mode was compared";
  result.body.checks.push_back(
      {"free frequencies", compared == 0 || (worst_frequency < 0.1 && worst_mac > 0.9),
       fmt::format("{}; full model against reduced, the lower half must agree within "
                   "10 % and MAC 0.9 (rigid interfaces stiffen): {}",
                   trust, rows)});
}

bool attached(const ModelReduction& o) {
  return o.basis == ModelReduction::Basis::attachment || o.basis == ModelReduction::Basis::modal_truncation;
}

/// Whether eigenmodes are those of the free body: where the frame holds no interface, its attachment modes
/// are by inertia relief.
bool floats(const ModelReduction& o) {
  return o.basis == ModelReduction::Basis::free_interface ||
         (attached(o) && o.frame == ModelReduction::Frame::mean_axis);
}

void require_motions(const ModelReduction& o) {
  using Motion = Interface::Motion;
  const bool tangent = o.frame != ModelReduction::Frame::mean_axis;
  for (std::size_t i = 0; i < o.interfaces.size(); ++i)
    for (const Motion motion : o.interfaces[i].motions) {
      if (motion == Motion::retained) continue;
      const std::string& name = o.interfaces[i].name;
      if (o.basis == ModelReduction::Basis::krylov || floats(o) || o.user_modes.shapes.cols() > 0)
        throw std::invalid_argument(fmt::format(
            "interface '{}': motions are free or held in the Craig-Bampton basis and, in the tangent "
            "frame, in attachment and modal_truncation, without user modes only",
            name));
      if (tangent && i == 0)
        throw std::invalid_argument(
            fmt::format("interface '{}': the body frame moves with it, in all of its motions", name));
      if (!tangent && motion == Motion::held)
        throw std::invalid_argument(
            fmt::format("interface '{}': nothing can be held where the frame is that of the mean", name));
    }
}

void require(const ModelReduction& o) {
  using Basis = ModelReduction::Basis;
  if (o.interfaces.empty())
    throw std::invalid_argument("a body needs at least one interface, where something can hold it");
  if (o.dynamic_modes < 0 || o.free_modes < 0)
    throw std::invalid_argument("numbers of modes must not be negative");
  const auto sound = [](double x) { return std::isfinite(x) && x >= 0; };
  if (!sound(o.stiffness_damping)) throw std::invalid_argument("stiffness damping must not be negative");
  if (!sound(o.max_frequency) || !sound(o.krylov_frequency))
    throw std::invalid_argument("frequencies must not be negative");
  if (!(o.effective_mass >= 0 && o.effective_mass <= 100))
    throw std::invalid_argument("the effective mass is a share between 0 and 100 %");
  if (o.basis == Basis::krylov && o.max_frequency > 0)
    throw std::invalid_argument("vectors of the Krylov basis have no frequencies: give their number");
  if (o.basis != Basis::krylov && o.krylov_frequency > 0)
    throw std::invalid_argument("the frequency to match about belongs to the Krylov basis");
  if (o.basis != Basis::craig_bampton && o.effective_mass > 0)
    throw std::invalid_argument("effective masses are those of the Craig-Bampton basis");
  if (o.basis != Basis::free_interface && o.basis != Basis::modal_truncation &&
      o.frame != ModelReduction::Frame::mean_axis && o.interfaces.size() == 1 && o.dynamic_modes == 0 &&
      o.max_frequency == 0 && o.loads.empty() && o.user_modes.shapes.cols() == 0)
    throw std::invalid_argument("one interface and no dynamic modes leave nothing that could deform");
  if (o.geometric_stiffness && (o.frame != ModelReduction::Frame::tangent || floats(o)))
    throw std::invalid_argument("geometric stiffness needs the tangent frame and a basis with static modes");
  require_motions(o);
  for (std::size_t i = 0; i < o.interfaces.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (o.interfaces[i].name == o.interfaces[j].name)
        throw std::invalid_argument(fmt::format("two interfaces are called '{}'", o.interfaces[i].name));
}

/// Keeps the dynamic modes, the last of the shapes, that have the effective mass asked for.
void keep_effective(const FeMatrices& matrices, const ModelReduction& options, const MatrixXd& R,
                    Shapes& shapes, ReductionResult& result) {
  const ModeSelection selection = select_modes(result.effective_mass, options.effective_mass);
  const Index all = shapes.dofs.cols(), dynamic = result.effective_mass.cols(), statics = all - dynamic;
  std::vector<Index> kept(static_cast<std::size_t>(statics));
  std::iota(kept.begin(), kept.end(), Index{0});
  for (const Index k : selection.kept) kept.push_back(statics + k);
  if (kept.empty()) throw std::invalid_argument("no dynamic mode has the effective mass asked for");

  double rise = 0;
  {
    // Motions of the first interface, there without a tangent frame, depend on the rigid ones and the others.
    const Index first = options.frame == ModelReduction::Frame::mean_axis ? 6 : 0;
    MatrixXd free(R.rows(), 6 + all - first);
    free << R, shapes.dofs.rightCols(all - first);
    std::vector<Index> some(6);
    std::iota(some.begin(), some.end(), Index{0});
    for (const Index k : kept)
      if (k >= first) some.push_back(6 + k - first);
    rise = frequency_rise(free.transpose() * symmetric_times(matrices.stiffness, free),
                          free.transpose() * symmetric_times(matrices.mass, free), some);
  }
  std::string dropped;
  for (const Index k : selection.dropped)
    dropped +=
        fmt::format("{}{} ({:.4g} Hz)", dropped.empty() ? "" : ", ", k + 1, result.fixed_frequencies[k]);
  const auto& s = selection.share;
  result.body.checks.push_back(
      {"mode selection", selection.reached,
       fmt::format("effective mass of {} of {} dynamic modes: {:.4g} %, {:.4g} %, {:.4g} % in translations, "
                   "{:.4g} %, {:.4g} %, {:.4g} % in rotations, {:.4g} % asked; dropped: {}; without them the "
                   "lowest free frequencies are up to {:.2g} % higher{}",
                   selection.kept.size(), dynamic, s[0], s[1], s[2], s[3], s[4], s[5], options.effective_mass,
                   dropped.empty() ? "none" : dropped, 100 * rise,
                   selection.reached ? "" : "; the modes computed have no more, ask for more of them")});

  Shapes some{shapes.dofs(Eigen::all, kept), shapes.points(Eigen::all, kept), {}};
  for (const Index k : kept) some.names.push_back(shapes.names[static_cast<std::size_t>(k)]);
  shapes = std::move(some);
  result.fixed_frequencies = result.fixed_frequencies(selection.kept).eval();
  result.effective_mass = result.effective_mass(Eigen::all, selection.kept).eval();
}

/// Appends what loads and the user's modes have beyond the shapes. Of `held` ones, which move with the
/// interfaces held, the loads' are part; in the free body's basis loads are among the forces already.
void add_asked(const SolidMesh& mesh, const FeMatrices& matrices, const ModelReduction& options,
               const MatrixXd& R, const TiedModel& tied, bool held, const Shapes& known, Shapes& shapes,
               ReducedBody& body) {
  std::vector<double> fresh;
  Shapes added{MatrixXd(shapes.dofs.rows(), 0), MatrixXd(shapes.points.rows(), 0), {}};
  if (held && !options.loads.empty()) {
    added = independent_shapes(matrices, known,
                               load_shapes(tied, matrices, options.interfaces, options.loads), fresh);
    for (Check& check : load_checks(options.loads, fresh)) body.checks.push_back(std::move(check));
  }
  if (options.user_modes.shapes.cols() > 0) {
    const ExpandedModes modes = expand_user_modes(mesh, matrices, options.interfaces, options.user_modes);
    Shapes user = held ? held_user_modes(tied, matrices, options.interfaces, modes)
                       : free_user_modes(matrices, options.interfaces, R, modes);
    added = join(added, independent_shapes(matrices, join(known, added), std::move(user), fresh));
    body.checks.push_back(user_modes_check(matrices, options.user_modes, modes, fresh));
  }
  shapes = join(shapes, added);
}

/// Of eigenmodes without their static parts those that are independent, and the deflections by inertia that
/// modal truncation augmentation adds.
Shapes add_truncated(const FeMatrices& matrices, const ModelReduction& options, const MatrixXd& R,
                     const TiedModel& tied, Shapes eigenmodes) {
  std::vector<double> fresh;
  const Shapes none{MatrixXd(eigenmodes.dofs.rows(), 0), MatrixXd(eigenmodes.points.rows(), 0), {}};
  if (options.basis == ModelReduction::Basis::modal_truncation)
    eigenmodes = join(eigenmodes,
                      held_shapes(tied, options.interfaces, inertia_responses(tied, matrices, R), "inertia"));
  return independent_shapes(matrices, none, std::move(eigenmodes), fresh);
}

/// For the sum of the modes: what those beside the static ones are.
std::string attached_text(const ModelReduction& options, Index eigenmodes) {
  if (options.basis == ModelReduction::Basis::attachment) return "with the first interface held";
  return fmt::format("({} with the first interface held, the others of inertia)", eigenmodes);
}

/// For the sum of the modes.
std::string freed_and_held(const std::vector<Interface>& interfaces) {
  int freed = 0, held = 0;
  for (const Interface& i : interfaces)
    for (const Interface::Motion motion : i.motions) {
      if (motion == Interface::Motion::free) ++freed;
      if (motion == Interface::Motion::held) ++held;
    }
  return (freed > 0 ? fmt::format(" − {} free", freed) : "") +
         (held > 0 ? fmt::format(" − {} held", held) : "");
}

/// Modes of the free body, and residual ones of forces; a typical ω² comes with them.
Shapes free_basis(const SolidMesh& mesh, const FeMatrices& matrices, const ModelReduction& options,
                  const TiedModel& tied, const MatrixXd& R, const std::function<void(double)>& progress,
                  double& scale, ReducedBody& body) {
  VectorXd eigenvalues;
  Shapes shapes =
      free_interface_shapes(tied, matrices, options.interfaces, R, options.dynamic_modes,
                            std::pow(options.max_frequency / kHertz, 2), load_forces(matrices, options.loads),
                            load_names(options.loads), eigenvalues, progress);
  if (eigenvalues.size() > 0) scale = eigenvalues[0];
  const Index forces = shapes.dofs.cols() - eigenvalues.size();
  add_asked(mesh, matrices, options, R, tied, false, shapes, shapes, body);
  const Index user = shapes.dofs.cols() - eigenvalues.size() - forces;
  if (options.frame != ModelReduction::Frame::mean_axis) to_tangent(options.interfaces, R, shapes);
  body.checks.push_back(
      {"number of modes", true,
       fmt::format("{} = {} free + {} of forces at {} interface{}{}", shapes.dofs.cols(), eigenvalues.size(),
                   forces, options.interfaces.size(), options.interfaces.size() == 1 ? "" : "s",
                   (options.loads.empty() ? "" : fmt::format(" and {} loads", options.loads.size())) +
                       (user > 0 ? fmt::format(" + {} of the user", user) : ""))});
  return shapes;
}

/// The basis in the body's frame; a typical ω² comes with it.
Shapes basis_of(const SolidMesh& mesh, const FeMatrices& matrices, const ModelReduction& options,
                const TiedModel& tied, const MatrixXd& R, double& scale, ReductionResult& result) {
  using Basis = ModelReduction::Basis;
  const auto report = [&](const char* stage, double done) {
    if (options.progress) options.progress(stage, done);
  };
  const auto square = [](double hertz) { return std::pow(hertz / kHertz, 2); };
  const bool tangent = options.frame != ModelReduction::Frame::mean_axis;  // at first, or to the end
  const auto centred = [&](Shapes& shapes) {
    if (options.frame == ModelReduction::Frame::centre_of_mass)
      to_centre_of_mass(matrices, options.interfaces, R, shapes);
  };
  report("dynamic modes", 0);
  const auto progress = [&](double done) { report("dynamic modes", done); };
  Shapes shapes;
  if (floats(options)) {
    shapes = free_basis(mesh, matrices, options, tied, R, progress, scale, result.body);
    centred(shapes);
    return shapes;
  }
  MatrixXd x;
  Index eigenmodes = 0;
  if (attached(options)) {
    VectorXd eigenvalues;
    x = attached_eigenmodes(tied, matrices, options.interfaces, options.dynamic_modes,
                            square(options.max_frequency), eigenvalues, progress);
    if (eigenvalues.size() > 0) scale = eigenvalues[0];
    eigenmodes = x.cols();
  } else if (options.basis == Basis::krylov) {
    x = krylov_vectors(mesh, tied, matrices, options.interfaces, square(options.krylov_frequency),
                       options.dynamic_modes);
  } else {
    Modes held = options.max_frequency > 0
                     ? block_lanczos_below(tied.held(), square(options.max_frequency), progress)
                     : block_lanczos(tied.held(), options.dynamic_modes, progress);
    if (held.eigenvalues.size() > 0) scale = held.eigenvalues[0];
    result.fixed_frequencies = held.eigenvalues.cwiseMax(0).cwiseSqrt() * kHertz;
    x = std::move(held.vectors);
  }
  report("static modes", 0);
  shapes = static_shapes(tied, matrices, options.interfaces, tangent ? 1 : 0);
  const bool krylov = options.basis == Basis::krylov;
  const char* kind = krylov ? "krylov" : attached(options) ? "eigenmode" : "dynamic";
  Shapes held = held_shapes(tied, options.interfaces, x, kind);
  if (attached(options)) held = add_truncated(matrices, options, R, tied, std::move(held));
  shapes = join(shapes, held);
  if (options.basis == Basis::craig_bampton) {
    result.effective_mass = effective_mass(matrices, options.interfaces[0], R, held.dofs);
    if (options.effective_mass > 0) keep_effective(matrices, options, R, shapes, result);
  }
  const auto statics = static_cast<Index>(retained_motions(options.interfaces, tangent ? 1 : 0).size());
  const Index chosen = shapes.dofs.cols();
  {
    const Index moving = chosen - statics;
    const Shapes known{shapes.dofs.rightCols(moving), shapes.points.rightCols(moving), {}};
    add_asked(mesh, matrices, options, R, tied, true, known, shapes, result.body);
  }
  const Index asked = shapes.dofs.cols() - chosen;
  const std::size_t interfaces = options.interfaces.size();
  if (shapes.dofs.cols() == 0)
    throw std::invalid_argument(
        "one interface and no dynamic mode below the frequency leave nothing that could deform");
  result.body.checks.push_back(
      {"number of modes", true,
       fmt::format("{} = {} motions of {} interface{} − 6 of the body{} + {} {}{}",
                   shapes.dofs.cols() - (tangent ? 0 : 6), tied.boundaries(), interfaces,
                   interfaces == 1 ? "" : "s", freed_and_held(options.interfaces), chosen - statics,
                   krylov              ? "Krylov"
                   : attached(options) ? attached_text(options, eigenmodes)
                                       : "dynamic",
                   asked > 0 ? fmt::format(" + {} of loads and the user", asked) : "")});
  if (!tangent) to_mean_axes(matrices, options.interfaces, R, shapes);
  centred(shapes);
  return shapes;
}

/// Whether constraints leave nothing of the stiffness but rounding.
bool all_rigid(const FeMatrices& all, const FeMatrices& left) {
  constexpr double rounding = 1e-10;
  const auto largest = [](const Eigen::SparseMatrix<double>& matrix) {
    return matrix.nonZeros() > 0 ? matrix.coeffs().abs().maxCoeff() : 0.0;
  };
  return largest(left.stiffness) <= rounding * largest(all.stiffness);
}

/// Throws where a check of the matrices failed without which there is no body. `rigid`: nothing can deform.
void require_sound(const std::vector<Check>& checks, bool rigid) {
  for (const Check& check : checks)
    if (!check.passed && (check.name == "sizes" || check.name == "finite numbers" ||
                          check.name == "positive diagonals" || check.name == "rigid motions"))
      throw std::invalid_argument(rigid
                                      ? "rigid elements and equations tie all of the model together, so that "
                                        "it cannot deform: in the model file it is a rigid body"
                                      : fmt::format("{}: {}", check.name, check.detail));
}

Check loose_rotations_check(const SolidMesh& mesh, const std::vector<Dof>& loose) {
  return {"loose rotations", true,
          fmt::format("{} rotations that nothing resists are left out, the first of node {} about {}",
                      loose.size(), label_of(mesh, loose.front().node), "xyz"[loose.front().direction - 3])};
}

void add_frames(const std::vector<Interface>& interfaces, const Shapes& shapes, ReducedBody& body) {
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    const Interface& interface = interfaces[i];
    const auto rows = shapes.points.middleRows<6>(static_cast<Index>(6 * i));
    body.frames.push_back(
        {interface.name, interface.point, interface.axes, rows.topRows<3>(), rows.bottomRows<3>()});
  }
}

void add_final_checks(const MatrixXd& mass, ReducedBody& body) {
  const double overlap = (body.user_from_modal.transpose() * mass * body.user_from_modal -
                          MatrixXd::Identity(body.modes, body.modes))
                             .cwiseAbs()
                             .maxCoeff();
  body.checks.push_back({"orthogonal modes", overlap < 1e-8, fmt::format("to {:.1g}", overlap)});
  std::string unsound;
  for (const std::string& message : check(body)) unsound += (unsound.empty() ? "" : "; ") + message;
  body.checks.push_back({"reduced body", unsound.empty(), unsound.empty() ? "sound" : unsound});
}

}  // namespace

Vector3d centre_of(const SolidMesh& mesh, const std::vector<int>& nodes) {
  Vector3d sum = Vector3d::Zero();
  for (const int node : nodes) sum += mesh.nodes.col(node);
  return nodes.empty() ? sum : Vector3d(sum / static_cast<double>(nodes.size()));
}

ReductionResult reduce(const SolidMesh& mesh, const FeMatrices& given, const ModelReduction& wanted) {
  const bool lumped = wanted.mass_matrix == MassMatrix::lumped;
  const FeMatrices own = lumped ? lump_masses(mesh, given) : FeMatrices{};
  const FeMatrices& all = lumped ? own : given;
  const bool constrained = has_constraints(mesh) || has_loose_rotations(all);
  ModelReduction options = wanted;
  if (constrained) options.interfaces = at_references(mesh, options.interfaces);
  const auto report = [&](const char* stage, double done) {
    if (options.progress) options.progress(stage, done);
  };
  require(options);
  report("checks", 0);
  std::vector<Dof> loose;
  const FeMatrices left = constrained ? constrain(mesh, all, options.interfaces, &loose) : FeMatrices{};
  const FeMatrices& matrices = constrained ? left : all;
  const auto expanded = [&](const MatrixXd& x) -> MatrixXd {
    return constrained ? MatrixXd(left.expansion * x) : x;
  };
  ReductionResult result;
  result.body.checks = check_matrices(mesh, matrices, options.interfaces);
  require_sound(result.body.checks, constrained && all_rigid(all, left));
  result.body.checks.push_back(connected_check(mesh, matrices, options.interfaces));
  if (!result.body.checks.back().passed) throw std::invalid_argument(result.body.checks.back().detail);
  if (!loose.empty()) result.body.checks.push_back(loose_rotations_check(mesh, loose));
  if (lumped) result.body.checks.push_back(lumped_check(given, all, rigid_shapes(mesh, all)));

  const MatrixXd R = rigid_shapes(mesh, matrices);
  if (!options.stress.nodes.empty()) {
    require(options.stress, mesh, all);
    result.body.checks.push_back(check_rigid(options.stress, expanded(R)));
  }
  double scale = 0;  // a typical ω²
  report("factorisation", 0);
  std::optional<TiedModel> held(std::in_place, mesh, matrices, options.interfaces);
  const Shapes shapes = basis_of(mesh, matrices, options, *held, R, scale, result);
  if (scale == 0)
    scale = shapes.dofs.cwiseProduct(symmetric_times(matrices.stiffness, shapes.dofs)).sum() /
            shapes.dofs.cwiseProduct(symmetric_times(matrices.mass, shapes.dofs)).sum();

  report("integrals", 0);
  ReducedBody& body = result.body;
  body.modes = static_cast<int>(shapes.dofs.cols());
  body.mode_names = shapes.names;
  const MatrixXd mass = shapes.dofs.transpose() * symmetric_times(matrices.mass, shapes.dofs),
                 stiffness = shapes.dofs.transpose() * symmetric_times(matrices.stiffness, shapes.dofs);
  const MatrixXd all_shapes = expanded(shapes.dofs);
  const MatrixXd displacements = node_shapes(mesh, all, all_shapes);
  if (lumped && has_rotating_mass(mesh))
    add_lumped_integrals(mesh, all.dofs, all_shapes, body);
  else if (all.of_mesh && has_rotating_mass(mesh))
    add_point_integrals(mesh, all.dofs, all_shapes, body);
  else
    add_shape_integrals(mesh.nodes, nodal_mass_of(mesh, all), displacements, body);
  body.mass_matrix = 0.5 * (mass + mass.transpose());
  body.stiffness = 0.5 * (stiffness + stiffness.transpose());
  body.damping = options.stiffness_damping * body.stiffness;
  add_frames(options.interfaces, shapes, body);
  report("stress", 0);
  add_surface(mesh, all, all_shapes, displacements, options.stress, body);
  if (options.geometric_stiffness) {
    report("geometric stiffness", 0);
    MatrixXd forces = unit_inertia_forces(mesh, all);
    if (constrained) forces = (left.expansion.transpose() * forces).eval();
    const MatrixXd x = held->solve(held->restrict(forces));
    const MatrixXd responses = expanded(held->expand(x, MatrixXd::Zero(held->boundaries(), x.cols())));
    body.geometric = solid_stiffening(mesh, responses, all_shapes, body.stiffness,
                                      static_cast<Index>(retained_motions(options.interfaces, 1).size()));
  }
  report("stretching", 0);
  body.stretching = stretching_of_mesh(mesh, all, matrices, options.interfaces, *held, shapes, body);
  held.reset();  // the free model's factors take its place in memory
  make_orthogonal(body);

  add_final_checks(mass, body);
  add_free_modes(matrices, options, R, shapes.dofs, scale, result);
  report("done", 1);
  return result;
}

}  // namespace mimbre::fe
