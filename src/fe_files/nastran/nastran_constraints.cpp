#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "fe_files/nastran/nastran_build.h"
#include "math/once/decompositions.h"

// MSC Nastran Quick Reference Guide, RBE2, RBE3, MPC, CELAS, CBUSH, CONM2.

namespace mimbre::fe {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr unsigned kTranslations = 7, kRotations = 56;

std::array<bool, 6> flags(unsigned components) {
  std::array<bool, 6> result{};
  for (unsigned k = 0; k < 6; ++k) result[k] = (components >> k & 1u) != 0;
  return result;
}

/// Whether components mean the same in every system: all three translations or none, all rotations or none.
bool whole(unsigned components) {
  const unsigned t = components & kTranslations, r = components & kRotations;
  return (t == 0 || t == kTranslations) && (r == 0 || r == kRotations);
}

void add_equation(NastranBuild& build, const std::string& name, std::vector<LinearTerm> terms) {
  build.tidy(terms, true);
  if (terms.empty()) return;
  // The first term is the one that is eliminated: of its node, the largest.
  const int node = terms.front().node;
  const bool turn = terms.front().direction >= 3;
  auto largest = terms.begin();
  for (auto term = terms.begin(); term != terms.end(); ++term)
    if (term->node == node && (term->direction >= 3) == turn &&
        std::abs(term->factor) > std::abs(largest->factor))
      largest = term;
  std::iter_swap(terms.begin(), largest);
  build.mesh.equations.push_back({name, std::move(terms)});
}

/// Component k of a node follows the rigid motion of the reference.
void follow(NastranBuild& build, const NastranRigid& rigid, const std::string& name, int reference, int node,
            int component) {
  const Vector3d axis = build.directions(node, rigid.place).col(component % 3);
  std::vector<LinearTerm> terms;
  if (component < 3) {
    NastranBuild::add_translation(node, axis, Vector3d::Zero(), 1, terms);
    NastranBuild::add_translation(reference, axis, build.at(node) - build.at(reference), -1, terms);
  } else {
    NastranBuild::add_rotation(node, axis, 1, terms);
    NastranBuild::add_rotation(reference, axis, -1, terms);
  }
  add_equation(build, build.named(name, rigid.place), std::move(terms));
}

void add_rigid(NastranBuild& build, const NastranRigid& rigid) {
  const std::string name = fmt::format("{} {}", rigid.card, rigid.label);
  const int reference = build.node(rigid.reference, rigid.place, name);
  if (reference < 0) return;
  std::map<unsigned, RigidElement> by_components;
  for (const auto& [label, components] : rigid.followers) {
    const int node = build.node(label, rigid.place, name);
    if (node < 0) continue;
    if (node == reference) throw std::invalid_argument(fmt::format("node {} follows itself", label));
    if (components == 0) {  // RROD
      const Vector3d along = build.at(node) - build.at(reference);
      if (!(along.norm() > 0)) throw std::invalid_argument("has no length");
      std::vector<LinearTerm> terms;
      NastranBuild::add_translation(node, along.normalized(), Vector3d::Zero(), 1, terms);
      NastranBuild::add_translation(reference, along.normalized(), Vector3d::Zero(), -1, terms);
      add_equation(build, build.named(name, rigid.place), std::move(terms));
      continue;
    }
    build.rotates[static_cast<std::size_t>(reference)] = 1;
    if ((components & kRotations) != 0) build.rotates[static_cast<std::size_t>(node)] = 1;
    if (whole(components) || build.directions(node, rigid.place).isIdentity(1e-9)) {
      RigidElement& element = by_components[components];
      element.nodes.push_back(node);
    } else {
      for (int k = 0; k < 6; ++k)
        if ((components >> k & 1u) != 0) follow(build, rigid, name, reference, node, k);
    }
  }
  for (auto& [components, element] : by_components) {
    element.name = build.named(name, rigid.place);
    element.reference = reference;
    element.follows = flags(components);
    std::sort(element.nodes.begin(), element.nodes.end());
    element.nodes.erase(std::unique(element.nodes.begin(), element.nodes.end()), element.nodes.end());
    build.mesh.rigid_elements.push_back(std::move(element));
  }
}

/// The reference's motion x that is nearest to components of nodes, by weighted squares (rotations by the
/// square of the mean distance): x = (Σ w sᵀ s)⁻¹ Σ w sᵀ u.
void add_mean_equations(NastranBuild& build, const NastranMean& mean, const std::string& name,
                        int reference) {
  struct Row {
    int node;
    int component;
    Vector3d axis;
    double weight;
  };
  std::vector<Row> rows;
  double distance = 0;
  std::size_t count = 0;
  for (const NastranMean::Node& one : mean.nodes) {
    const int node = build.node(one.node, mean.place, name);
    if (node < 0) return;
    distance += (build.at(node) - build.at(reference)).norm();
    ++count;
  }
  distance /= static_cast<double>(std::max<std::size_t>(count, 1));
  for (const NastranMean::Node& one : mean.nodes) {
    const int node = build.by_label.at(one.node);
    const Matrix3d directions = build.directions(node, mean.place);
    for (int k = 0; k < 6; ++k) {
      if ((one.components >> k & 1u) == 0) continue;
      if (k >= 3 && !build.rotates[static_cast<std::size_t>(node)]) continue;
      rows.push_back({node, k, directions.col(k % 3), one.weight * (k < 3 ? 1 : distance * distance)});
    }
  }
  MatrixXd S(rows.size(), 6);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Row& row = rows[r];
    const auto i = static_cast<Eigen::Index>(r);
    const Vector3d arm = build.at(row.node) - build.at(reference);
    S.row(i).setZero();
    if (row.component < 3) {
      S.row(i).head<3>() = row.axis;
      S.row(i).tail<3>() = arm.cross(row.axis);
    } else {
      S.row(i).tail<3>() = row.axis;
    }
  }
  // In lengths of the mean distance, so that turns and displacements have one scale.
  if (distance > 0) S.rightCols(3) /= distance;
  MatrixXd weighted = S.transpose();
  for (std::size_t r = 0; r < rows.size(); ++r) weighted.col(static_cast<Eigen::Index>(r)) *= rows[r].weight;
  const MatrixXd normal = weighted * S;
  const Eigen::VectorXd values = symmetric_eigenvalues(normal);
  if (values.size() != 6 || !(values[0] > 1e-10 * values[5]))
    throw std::invalid_argument(
        "its nodes do not determine a rigid motion: they lie on a line or are too few");
  MatrixXd W = PivotedCholesky(normal).solve(weighted);
  if (distance > 0) W.bottomRows(3) /= distance;
  const Matrix3d directions = build.directions(reference, mean.place);
  for (int k = 0; k < 6; ++k) {
    if ((mean.components >> k & 1u) == 0) continue;
    const Vector3d axis = directions.col(k % 3);
    std::vector<LinearTerm> terms;
    build.add_component(reference, k, 1, mean.place, terms);
    const Eigen::RowVectorXd factors = axis.transpose() * (k < 3 ? W.topRows(3) : W.bottomRows(3));
    for (std::size_t r = 0; r < rows.size(); ++r)
      for (int d = 0; d < 3; ++d)
        terms.push_back({rows[r].node, (rows[r].component < 3 ? 0 : 3) + d,
                         -factors[static_cast<Eigen::Index>(r)] * rows[r].axis[d]});
    add_equation(build, build.named(name, mean.place), std::move(terms));
  }
}

/// Nodes on a line do not turn about it: enough for translations of places on that line alone.
bool determine(const NastranBuild& build, const MeanElement& element) {
  const auto count = static_cast<Eigen::Index>(element.nodes.size());
  if (count == 0) return false;
  Eigen::Matrix3Xd arms(3, count + 1);
  for (Eigen::Index k = 0; k < count; ++k) arms.col(k) = build.at(element.nodes[static_cast<std::size_t>(k)]);
  arms.col(count) = build.at(element.reference);
  const Vector3d first = arms.col(0);
  arms.colwise() -= first;
  const double size = arms.colwise().norm().maxCoeff(), close = 1e-6 * size;
  Eigen::Index far = 0;
  arms.leftCols(count).colwise().norm().maxCoeff(&far);
  const auto off_line = [&](Eigen::Index k) {
    const Vector3d line = arms.col(far);
    return line.norm() > close ? line.normalized().cross(arms.col(k)).norm() : arms.col(k).norm();
  };
  for (Eigen::Index k = 0; k < count; ++k)
    if (off_line(k) > close) return true;
  const bool turns = element.follows[3] || element.follows[4] || element.follows[5];
  return !turns && off_line(count) <= close;
}

void add_mean(NastranBuild& build, const NastranMean& mean) {
  const std::string name = fmt::format("RBE3 {}", mean.label);
  const int reference = build.node(mean.reference, mean.place, name);
  if (reference < 0) return;
  if ((mean.components & kRotations) != 0) build.rotates[static_cast<std::size_t>(reference)] = 1;
  const bool plain = std::all_of(mean.nodes.begin(), mean.nodes.end(),
                                 [](const auto& n) { return n.components == kTranslations; });
  if (!plain || !(whole(mean.components) || build.directions(reference, mean.place).isIdentity(1e-9)))
    return add_mean_equations(build, mean, name, reference);
  MeanElement element;
  element.name = build.named(name, mean.place);
  element.reference = reference;
  element.follows = flags(mean.components);
  for (const NastranMean::Node& one : mean.nodes) {
    const int node = build.node(one.node, mean.place, name);
    if (node < 0) return;
    if (!(one.weight > 0)) continue;
    element.nodes.push_back(node);
    element.weights.push_back(one.weight);
  }
  if (!determine(build, element))
    throw std::invalid_argument(
        "its nodes do not determine a rigid motion: they lie on a line or are too few");
  build.mesh.mean_elements.push_back(std::move(element));
}

/// The sets of equations that count: those of the case control; without one the only one that is there.
std::vector<std::int64_t> chosen_sets(NastranModel& model) {
  std::vector<std::int64_t> chosen;
  if (!model.equation_sets.empty()) {
    chosen = {model.equation_sets.front()};
    for (const std::int64_t other : model.equation_sets)
      if (other != chosen.front())
        model.warn(
            "MPC sets", model.mark(model.equations.empty() ? NastranPlace{} : model.equations.front().place),
            fmt::format("subcases have different sets of MPC; {} of the first is taken", chosen.front()));
  } else if (!model.has_control && !model.equations.empty()) {
    chosen = {model.equations.front().set};
    for (const NastranEquation& one : model.equations)
      if (one.set != chosen.front())
        throw InputError(
            model.mark(one.place),
            "there are several sets of MPC and no case control that takes one of them (MPC = 1)");
  }
  for (std::size_t i = 0; i < chosen.size() && chosen.size() < 10'000; ++i)
    if (const auto sum = model.equation_sums.find(chosen[i]); sum != model.equation_sums.end())
      for (const std::int64_t part : sum->second)
        if (std::find(chosen.begin(), chosen.end(), part) == chosen.end()) chosen.push_back(part);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void add_equations(NastranBuild& build) {
  NastranModel& model = build.model;
  const std::vector<std::int64_t> chosen = chosen_sets(model);
  for (const NastranEquation& equation : model.equations) {
    const std::string name = fmt::format("MPC {}", equation.set);
    if (!std::binary_search(chosen.begin(), chosen.end(), equation.set)) {
      model.warn(name, model.mark(equation.place),
                 fmt::format("{}: is left out, the case control does not take this set", name));
      continue;
    }
    build.guarded(name, equation.place, [&] {
      std::vector<LinearTerm> terms;
      for (const NastranTerm& term : equation.terms) {
        if (model.is_scalar_point(term.node)) {
          model.warn(
              "MPC of scalar points", model.mark(equation.place),
              fmt::format("{}: has a scalar point, which is no part of a body, and is left out", name));
          return;
        }
        const int node = build.node(term.node, equation.place, name);
        if (node < 0) return;
        if (term.component < 0)
          throw std::invalid_argument(fmt::format("node {} needs a component from 1 to 6", term.node));
        if (term.component >= 3 && !build.rotates[static_cast<std::size_t>(node)]) {
          model.warn("MPC rotations", model.mark(equation.place),
                     fmt::format("{}: node {} has no rotations; they are taken as held", name, term.node));
          continue;
        }
        build.add_component(node, term.component, term.factor, equation.place, terms);
      }
      add_equation(build, build.named(name, equation.place), std::move(terms));
    });
  }
}

/// A spring between rotations turns both its nodes where one of them turns, and so on along a row of springs.
/// Where none does it is left out.
void turn_along_springs(NastranBuild& build) {
  const NastranModel& model = build.model;
  std::vector<std::vector<int>> neighbours(build.rotates.size());
  const auto add = [&](const std::array<std::int64_t, 2>& labels) {
    const auto a = build.by_label.find(labels[0]), b = build.by_label.find(labels[1]);
    if (a == build.by_label.end() || b == build.by_label.end()) return;
    neighbours[static_cast<std::size_t>(a->second)].push_back(b->second);
    neighbours[static_cast<std::size_t>(b->second)].push_back(a->second);
  };
  for (const NastranScalar& spring : model.springs)
    if (spring.components[0] >= 3 && spring.components[1] >= 3) add(spring.nodes);
  for (const NastranBush& bush : model.bushes) {
    const auto property = model.bush_properties.find(bush.property);
    if (property == model.bush_properties.end()) continue;
    const std::array<double, 6>& K = property->second;
    if (K[3] != 0 || K[4] != 0 || K[5] != 0) add(bush.nodes);
  }
  std::vector<int> turning;
  for (std::size_t k = 0; k < build.rotates.size(); ++k)
    if (build.rotates[k] != 0) turning.push_back(static_cast<int>(k));
  while (!turning.empty()) {
    const auto node = static_cast<std::size_t>(turning.back());
    turning.pop_back();
    for (const int other : neighbours[node])
      if (char& turns = build.rotates[static_cast<std::size_t>(other)]; turns == 0) {
        turns = 1;
        turning.push_back(other);
      }
  }
}

void add_scalar_spring(NastranBuild& build, const NastranScalar& spring) {
  NastranModel& model = build.model;
  const std::string name = fmt::format("{} {}", spring.card, spring.label);
  double stiffness = spring.value;
  if (spring.property > 0) {
    const auto found = model.spring_properties.find(spring.property);
    if (found == model.spring_properties.end())
      throw std::invalid_argument(fmt::format("property {} is not there", spring.property));
    stiffness = found->second;
  }
  std::vector<LinearTerm> terms;
  for (std::size_t i = 0; i < 2; ++i) {
    if (model.is_scalar_point(spring.nodes[i])) {
      model.warn(
          "scalar points", model.mark(spring.place),
          fmt::format("{}: hangs on a scalar point, which is no part of a body, and is left out", name));
      return;
    }
    if (spring.nodes[i] == 0) {
      model.warn("ground", model.mark(spring.place),
                 fmt::format("{}: holds the body to the ground and is left out: a body is free", name));
      return;
    }
    const int node = build.node(spring.nodes[i], spring.place, name);
    if (node < 0) return;
    if (spring.components[i] < 0)
      throw std::invalid_argument(fmt::format("node {} needs a component from 1 to 6", spring.nodes[i]));
    build.add_component(node, spring.components[i], i == 0 ? -1 : 1, spring.place, terms);
  }
  if (stiffness == 0) return;
  if (!(stiffness > 0)) throw std::invalid_argument(fmt::format("its stiffness {} is negative", stiffness));
  build.tidy(terms, false);
  if (!terms.empty()) build.mesh.springs.push_back({name, stiffness, std::move(terms)});
}

void add_bush(NastranBuild& build, const NastranBush& bush) {
  NastranModel& model = build.model;
  const std::string name = fmt::format("CBUSH {}", bush.label);
  const auto property = model.bush_properties.find(bush.property);
  if (property == model.bush_properties.end())
    throw std::invalid_argument(fmt::format("property {} is not there", bush.property));
  if (bush.nodes[1] == 0) {
    model.warn("ground", model.mark(bush.place),
               fmt::format("{}: holds the body to the ground and is left out: a body is free", name));
    return;
  }
  const int a = build.node(bush.nodes[0], bush.place, name), b = build.node(bush.nodes[1], bush.place, name);
  if (a < 0 || b < 0) return;
  const Vector3d from = build.at(a), to = build.at(b), along = to - from;
  Matrix3d axes = Matrix3d::Identity();
  const std::array<double, 6>& K = property->second;
  const double scale = from.norm() + to.norm();
  if (bush.system) {
    axes = model.systems.at(*bush.system, model.mark(bush.place)).directions(from);
  } else if (along.norm() > 1e-9 * scale) {
    Vector3d direction = build.directions(a, bush.place) * bush.direction;
    if (bush.direction_node > 0) {
      const int node = build.node(bush.direction_node, bush.place, name);
      if (node < 0) return;
      direction = build.at(node) - from;
    }
    axes.col(0) = along.normalized();
    Vector3d z = axes.col(0).cross(direction);
    if (!(z.norm() > 1e-6 * direction.norm())) {
      if (K[1] != 0 || K[2] != 0 || K[4] != 0 || K[5] != 0)
        throw std::invalid_argument("needs a direction (X1, X2, X3 or G0) across it, or a system (CID)");
      Eigen::Index least = 0;
      axes.col(0).cwiseAbs().minCoeff(&least);
      z = axes.col(0).cross(Vector3d(Vector3d::Unit(least)));
    }
    axes.col(2) = z.normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
  }
  Vector3d place = from + bush.place_along * along;
  if (bush.offset_system) {
    // From the first node, in the system named.
    const NastranSystem& system = model.systems.at(*bush.offset_system, model.mark(bush.place));
    place = from + system.directions(from) * bush.offset;
  }
  for (int k = 0; k < 6; ++k) {
    const double stiffness = K[static_cast<std::size_t>(k)];
    if (stiffness == 0) continue;
    if (!(stiffness > 0)) throw std::invalid_argument(fmt::format("its stiffness {} is negative", stiffness));
    const Vector3d axis = axes.col(k % 3);
    std::vector<LinearTerm> terms;
    if (k < 3) {
      // A force across the length needs moments at the nodes, or the body would turn.
      const auto balanced = [&](int node, const Vector3d& arm) {
        return build.rotates[static_cast<std::size_t>(node)] || arm.cross(axis).norm() <= 1e-9 * arm.norm();
      };
      if (!balanced(b, place - to) || !balanced(a, place - from)) {
        model.warn("bush across", model.mark(bush.place),
                   fmt::format("{}: its stiffness across its length is left out: its nodes have no rotations",
                               name));
        continue;
      }
      NastranBuild::add_translation(b, axis, place - to, 1, terms);
      NastranBuild::add_translation(a, axis, place - from, -1, terms);
    } else {
      NastranBuild::add_rotation(b, axis, 1, terms);
      NastranBuild::add_rotation(a, axis, -1, terms);
    }
    build.tidy(terms, false);
    if (!terms.empty()) build.mesh.springs.push_back({name, stiffness, std::move(terms)});
  }
}

void add_mass(NastranBuild& build, const NastranMass& mass) {
  const std::string name = fmt::format("mass {}", mass.label);
  const int node = build.node(mass.node, mass.place, name);
  if (node < 0) return;
  if (!(mass.mass >= 0)) throw std::invalid_argument("a mass must not be negative");
  PointMass point;
  point.name = name;
  point.node = node;
  point.mass = mass.mass * build.model.mass_factor;
  Matrix3d axes = Matrix3d::Identity();
  if (mass.system == -1) {
    point.offset = mass.offset - build.at(node);
  } else {
    axes = build.model.systems.at(mass.system, build.model.mark(mass.place)).directions(build.at(node));
    point.offset = axes * mass.offset;
  }
  point.inertia = build.model.mass_factor * axes * mass.inertia * axes.transpose();
  if (mass.mass == 0 && mass.inertia.isZero(0)) return;
  if (!mass.inertia.isZero(0) || !point.offset.isZero(0)) build.rotates[static_cast<std::size_t>(node)] = 1;
  build.mesh.point_masses.push_back(std::move(point));
}

/// CMASS cards of a node make one rigid part, where they are equal in all directions.
void add_scalar_masses(NastranBuild& build) {
  NastranModel& model = build.model;
  struct Sum {
    std::array<double, 6> mass{};
    const NastranScalar* first = nullptr;
  };
  std::map<int, Sum> sums;
  for (const NastranScalar& one : model.scalar_masses) {
    const std::string name = fmt::format("{} {}", one.card, one.label);
    build.guarded(name, one.place, [&] {
      double mass = one.value;
      if (one.property > 0) {
        const auto found = model.mass_properties.find(one.property);
        if (found == model.mass_properties.end())
          throw std::invalid_argument(fmt::format("property {} is not there", one.property));
        mass = found->second;
      }
      const std::size_t end = one.nodes[0] != 0 ? 0 : 1;
      if (one.nodes[0] != 0 && one.nodes[1] != 0)
        throw std::invalid_argument("a mass between two components is no part of a body");
      if (model.is_scalar_point(one.nodes[end])) {
        model.warn(
            "scalar points", model.mark(one.place),
            fmt::format("{}: hangs on a scalar point, which is no part of a body, and is left out", name));
        return;
      }
      const int node = build.node(one.nodes[end], one.place, name);
      if (node < 0) return;
      if (one.components[end] < 0)
        throw std::invalid_argument(fmt::format("node {} needs a component from 1 to 6", one.nodes[end]));
      Sum& sum = sums[node];
      sum.mass[static_cast<std::size_t>(one.components[end])] += mass;
      if (!sum.first) sum.first = &one;
    });
  }
  for (const auto& [node, sum] : sums) {
    const std::string name = fmt::format("{} {}", sum.first->card, sum.first->label);
    build.guarded(name, sum.first->place, [&, node = node, sum = sum] {
      const auto& m = sum.mass;
      const double largest = std::max({m[0], m[1], m[2]}), least = std::min({m[0], m[1], m[2]});
      if (!(largest - least <= 1e-9 * largest))
        throw std::invalid_argument(fmt::format(
            "node {} has a mass of {}, {}, {} along 1, 2, 3; a body's is the same in all directions",
            build.mesh.labels[static_cast<std::size_t>(node)], m[0], m[1], m[2]));
      const Matrix3d axes = build.directions(node, sum.first->place);
      PointMass point;
      point.name = name;
      point.node = node;
      point.mass = largest * model.mass_factor;
      point.inertia = model.mass_factor * axes * Vector3d(m[3], m[4], m[5]).asDiagonal() * axes.transpose();
      if (!point.inertia.isZero(0)) build.rotates[static_cast<std::size_t>(node)] = 1;
      if (point.mass > 0 || !point.inertia.isZero(0)) build.mesh.point_masses.push_back(std::move(point));
    });
  }
}

}  // namespace

void add_nastran_ties(NastranBuild& build) {
  NastranModel& model = build.model;
  for (const NastranMass& mass : model.masses)
    build.guarded(fmt::format("mass {}", mass.label), mass.place, [&] { add_mass(build, mass); });
  add_scalar_masses(build);
  for (const NastranRigid& rigid : model.rigid)
    build.guarded(fmt::format("{} {}", rigid.card, rigid.label), rigid.place,
                  [&] { add_rigid(build, rigid); });
  for (const NastranMean& mean : model.means)
    build.guarded(fmt::format("RBE3 {}", mean.label), mean.place, [&] { add_mean(build, mean); });
  build.guarded("MPC", {}, [&] { add_equations(build); });
  turn_along_springs(build);
  for (const NastranScalar& spring : model.springs)
    build.guarded(fmt::format("{} {}", spring.card, spring.label), spring.place,
                  [&] { add_scalar_spring(build, spring); });
  for (const NastranBush& bush : model.bushes)
    build.guarded(fmt::format("CBUSH {}", bush.label), bush.place, [&] { add_bush(build, bush); });
}

}  // namespace mimbre::fe
