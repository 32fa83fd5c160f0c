#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "fe_files/nastran/nastran_build.h"

// MSC Nastran Quick Reference Guide, CBAR, CBEAM, CROD.

namespace mimbre::fe {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A bar between two places that hang on nodes.
struct Placed {
  std::array<int, 2> nodes{};
  std::array<Vector3d, 2> arms{Vector3d::Zero(),
                               Vector3d::Zero()};  ///< from the nodes to the ends of the axis
  Matrix3d axes = Matrix3d::Identity();            ///< columns x, y, z
  double length = 0;
};

Matrix3d axes_from(const Vector3d& x, const Vector3d& in_plane) {
  Matrix3d axes;
  axes.col(0) = x.normalized();
  const Vector3d z = axes.col(0).cross(in_plane);
  if (!(z.norm() > 1e-6 * in_plane.norm()))
    throw std::invalid_argument("its direction (X1, X2, X3 or G0) is missing or along the element");
  axes.col(2) = z.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

/// Any direction across x.
Vector3d across(const Vector3d& x) {
  Eigen::Index least = 0;
  x.cwiseAbs().minCoeff(&least);
  return Vector3d::Unit(least);
}

/// BAROR or BEAMOR give what its card leaves blank.
void complete(NastranBar& bar, const NastranBar& defaults) {
  if (bar.property == 0) bar.property = defaults.property > 0 && !bar.rod ? defaults.property : bar.label;
  if (bar.rod) return;
  if (!bar.has_direction) {
    bar.direction = defaults.direction;
    bar.direction_node = defaults.direction_node;
  }
  if (bar.axes.empty()) bar.axes = defaults.axes.empty() ? "GGG" : defaults.axes;
}

Placed placed(NastranBuild& build, const NastranBar& bar, const std::string& name) {
  Placed result;
  for (std::size_t i = 0; i < 2; ++i) {
    result.nodes[i] = build.node(bar.nodes[i], bar.place, name);
    if (result.nodes[i] < 0) return result;
  }
  const Vector3d a = build.at(result.nodes[0]), b = build.at(result.nodes[1]);
  if (bar.rod) {
    result.length = (b - a).norm();
    if (!(result.length > 0)) throw std::invalid_argument("has no length");
    result.axes = axes_from(b - a, across(b - a));
    return result;
  }
  Vector3d direction = bar.direction;
  if (bar.direction_node > 0) {
    const int node = build.node(bar.direction_node, bar.place, name);
    if (node < 0) return result;
    direction = build.at(node) - a;
  } else if (bar.axes[0] == 'G') {
    direction = build.directions(result.nodes[0], bar.place) * direction;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const Vector3d& offset = bar.offsets[i];
    if (offset.isZero(0)) continue;
    if (bar.axes[1 + i] == 'G')
      result.arms[i] = build.directions(result.nodes[i], bar.place) * offset;
    else if (bar.axes[1 + i] == 'B')
      result.arms[i] = offset;
    else  // along the element without offsets
      result.arms[i] = axes_from(b - a, direction) * offset;
  }
  const Vector3d x = b + result.arms[1] - a - result.arms[0];
  result.length = x.norm();
  const double size = (b - a).norm() + result.arms[0].norm() + result.arms[1].norm();
  if (!(result.length > 1e-12 * size)) throw std::invalid_argument("has no length");
  result.axes = axes_from(x, direction);
  return result;
}

/// Turns y and z until they are the principal axes of the section.
void to_principal(NastranSection& section, Matrix3d& axes) {
  if (section.I12 == 0) return;
  if (!(section.I1 * section.I2 >= section.I12 * section.I12))
    throw std::invalid_argument("its moments of area are those of no section: I1 I2 is below I12²");
  const double angle = 0.5 * std::atan2(2 * section.I12, section.I1 - section.I2), c = std::cos(angle),
               s = std::sin(angle);
  const double I1 = section.I1 * c * c + section.I2 * s * s + 2 * section.I12 * c * s;
  section.I2 = section.I1 + section.I2 - I1;
  section.I1 = I1;
  section.I12 = 0;
  const Vector3d y = c * axes.col(1) + s * axes.col(2);
  axes.col(2) = axes.col(0).cross(y);
  axes.col(1) = y;
}

/// A node of its own, with rotations.
int add_node(NastranBuild& build, const Vector3d& position, std::int64_t label) {
  SolidMesh& mesh = build.mesh;
  const auto added = static_cast<int>(mesh.nodes.cols());
  mesh.nodes.conservativeResize(3, added + 1);
  mesh.nodes.col(added) = position;
  mesh.labels.push_back(label);
  build.rotates.push_back(1);
  return added;
}

/// An end that is not held in some directions gets a node of its own, tied to the deck's in the others.
void release(NastranBuild& build, const NastranBar& bar, std::size_t end, const std::string& name,
             Placed& place) {
  const int old = place.nodes[end];
  const Vector3d arm = place.arms[end];
  const int added = add_node(build, build.at(old) + arm, -2 * bar.label - static_cast<std::int64_t>(end));
  for (int k = 0; k < 6; ++k) {
    if ((bar.released[end] >> k & 1u) != 0) continue;
    Equation equation;
    equation.name = name;
    const Vector3d axis = place.axes.col(k % 3);
    if (k < 3) {
      NastranBuild::add_translation(added, axis, Vector3d::Zero(), 1, equation.terms);
      NastranBuild::add_translation(old, axis, arm, -1, equation.terms);
    } else {
      NastranBuild::add_rotation(added, axis, 1, equation.terms);
      NastranBuild::add_rotation(old, axis, -1, equation.terms);
    }
    build.tidy(equation.terms, true);
    build.mesh.equations.push_back(std::move(equation));
  }
  place.nodes[end] = added;
  place.arms[end].setZero();
}

void add_spring(NastranBuild& build, const std::string& name, double stiffness,
                std::vector<LinearTerm> terms) {
  if (stiffness == 0) return;
  build.tidy(terms, true);
  if (!terms.empty()) build.mesh.springs.push_back({name, stiffness, std::move(terms)});
}

/// A bar that lacks some of its stiffness or its mass: its six ways to deform are springs, its mass is
/// lumped.
void add_by_springs(NastranBuild& build, const Placed& bar, const NastranSection& s,
                    const NastranMaterial& material, const std::string& name) {
  const double L = bar.length, E = material.young, G = material.shear;
  const auto& [a, b] = bar.nodes;
  const Vector3d x = bar.axes.col(0), y = bar.axes.col(1), z = bar.axes.col(2);
  const auto stretch = [&](const Vector3d& axis) {
    std::vector<LinearTerm> terms;
    NastranBuild::add_translation(b, axis, bar.arms[1], 1, terms);
    NastranBuild::add_translation(a, axis, bar.arms[0], -1, terms);
    return terms;
  };
  const auto twist = [&](const Vector3d& axis) {
    std::vector<LinearTerm> terms;
    NastranBuild::add_rotation(b, axis, 1, terms);
    NastranBuild::add_rotation(a, axis, -1, terms);
    return terms;
  };
  /// Deflection across, less what the mean of the turns makes of it.
  const auto shear = [&](const Vector3d& along, const Vector3d& about, double sign) {
    std::vector<LinearTerm> terms = stretch(along);
    for (const int node : {a, b}) NastranBuild::add_rotation(node, about, sign * L / 2, terms);
    return terms;
  };
  const auto flexible = [&](double I, double factor) {
    return factor > 0 && s.area > 0 ? 12 * E * I / (factor * s.area * G * L * L) : 0.0;
  };
  add_spring(build, name, E * s.area / L, stretch(x));
  add_spring(build, name, G * s.J / L, twist(x));
  add_spring(build, name, E * s.I1 / L, twist(z));
  add_spring(build, name, 12 * E * s.I1 / (L * L * L * (1 + flexible(s.I1, s.shear1))), shear(y, z, -1));
  add_spring(build, name, E * s.I2 / L, twist(y));
  add_spring(build, name, 12 * E * s.I2 / (L * L * L * (1 + flexible(s.I2, s.shear2))), shear(z, y, 1));
  const double mass = (material.density * s.area + s.mass) * L * build.model.mass_factor;
  if (mass > 0)
    for (std::size_t i = 0; i < 2; ++i)
      build.mesh.point_masses.push_back({name, bar.nodes[i], mass / 2, Matrix3d::Zero(), bar.arms[i]});
}

void add_beam(NastranBuild& build, const Placed& bar, const NastranSection& s,
              const NastranMaterial& material) {
  BeamElement beam;
  beam.nodes = bar.nodes;
  beam.offsets = bar.arms;
  beam.y_direction = bar.axes.col(1);
  beam.material = {material.young, material.poisson,
                   (material.density + s.mass / s.area) * build.model.mass_factor};
  beam.section.area = s.area;
  beam.section.Iy = s.I2;
  beam.section.Iz = s.I1;
  beam.section.J = s.J;
  // The torsion constant makes up for a shear modulus that is not E / 2(1 + ν).
  double poisson = material.young / (2 * material.shear) - 1;
  if (std::abs(poisson - material.poisson) < 1e-9) poisson = material.poisson;
  if (poisson > -0.99 && poisson <= 0.5) {
    beam.material.poisson = poisson;
  } else {
    beam.material.poisson = 0.3;
    beam.section.J *= material.shear / (material.young / 2.6);
  }
  const double G = material.young / (2 * (1 + beam.material.poisson));
  if (s.shear1 > 0 || s.shear2 > 0) {
    constexpr double rigid = 1e6;  // 0: no shear deformation that way
    beam.theory = BeamTheory::timoshenko;
    beam.section.shear_y = s.area * (s.shear1 > 0 ? s.shear1 : rigid) * material.shear / G;
    beam.section.shear_z = s.area * (s.shear2 > 0 ? s.shear2 : rigid) * material.shear / G;
  }
  beam.section.reach_y = s.reach_y;
  beam.section.reach_z = s.reach_z;
  beam.section.round = s.round;
  build.mesh.beams.push_back(std::move(beam));
}

/// The constant value whose flexibility is that of a linear change from a to b.
double flexible_mean(double a, double b) {
  const double ratio = b / a - 1;
  return std::abs(ratio) < 1e-4 ? (a + b) / 2 * (1 - ratio * ratio / 12) : (b - a) / std::log1p(ratio);
}

NastranSection between(const NastranSection& a, const NastranSection& b, double share) {
  NastranSection result = a;
  for (auto member : {&NastranSection::area, &NastranSection::I1, &NastranSection::I2, &NastranSection::I12,
                      &NastranSection::J, &NastranSection::mass, &NastranSection::shear1,
                      &NastranSection::shear2, &NastranSection::reach_y, &NastranSection::reach_z})
    result.*member = a.*member + share * (b.*member - a.*member);
  return result;
}

/// Of a piece of a tapered beam: flexibility of the piece, and its mass.
NastranSection of_piece(const NastranSection& a, const NastranSection& b, double density) {
  NastranSection result = between(a, b, 0.5);
  const double area = result.area, moments = result.I1 * result.I2;
  for (auto member : {&NastranSection::area, &NastranSection::I1, &NastranSection::I2, &NastranSection::J})
    result.*member = flexible_mean(a.*member, b.*member);
  result.I12 *= std::sqrt(result.I1 * result.I2 / moments);
  result.mass += density * (area - result.area);
  return result;
}

/// A beam whose section changes becomes pieces in which moments of area change by an eighth at most:
/// deflections then are right to 0.2 %, turns, twist and stretch to the last digit.
void add_tapered(NastranBuild& build, const Placed& bar, const std::vector<NastranStation>& stations,
                 const NastranMaterial& material) {
  constexpr double per_piece = 0.125;
  constexpr int most = 32;
  const Vector3d start = build.at(bar.nodes[0]) + bar.arms[0];
  const Vector3d along = build.at(bar.nodes[1]) + bar.arms[1] - start;
  Placed piece = bar;
  double at = 0;
  for (std::size_t k = 0; k + 1 < stations.size(); ++k) {
    const auto& [from, a] = stations[k];
    const auto& [to, b] = stations[k + 1];
    if (!(to > from)) continue;
    double change = 0;
    for (auto member : {&NastranSection::area, &NastranSection::I1, &NastranSection::I2, &NastranSection::J})
      change = std::max(change, std::abs(std::log(b.*member / a.*member)));
    const int count = std::clamp(static_cast<int>(std::ceil(change / per_piece)), 1, most);
    for (int i = 0; i < count; ++i) {
      const bool last = k + 2 == stations.size() && i + 1 == count;
      const double end = last ? 1 : from + (to - from) * (i + 1) / count;
      piece.nodes[1] = last ? bar.nodes[1] : add_node(build, start + end * along, 0);
      piece.arms[1] = last ? bar.arms[1] : Vector3d::Zero();
      piece.length = (end - at) * bar.length;
      piece.axes = bar.axes;
      NastranSection section = of_piece(between(a, b, static_cast<double>(i) / count),
                                        between(a, b, static_cast<double>(i + 1) / count), material.density);
      to_principal(section, piece.axes);
      add_beam(build, piece, section, material);
      piece.nodes[0] = piece.nodes[1];
      piece.arms[0] = piece.arms[1];
      at = end;
    }
  }
}

/// Whether it resists stretching, twisting and bending in every direction.
bool is_whole(const NastranSection& s) {
  return s.area > 0 && s.J > 0 && s.I1 > 0 && s.I1 * s.I2 - s.I12 * s.I12 > 1e-12 * s.I1 * s.I2;
}

/// Moves the ends of the axis to the centroids of their sections.
void to_centroids(NastranBuild& build, Placed& place, const NastranSection& a, const NastranSection& b) {
  place.arms[0] += place.axes.col(1) * a.centroid[0] + place.axes.col(2) * a.centroid[1];
  place.arms[1] += place.axes.col(1) * b.centroid[0] + place.axes.col(2) * b.centroid[1];
  if (a.centroid == b.centroid) return;
  const Vector3d x = build.at(place.nodes[1]) + place.arms[1] - build.at(place.nodes[0]) - place.arms[0];
  place.length = x.norm();
  place.axes = axes_from(x, place.axes.col(1));
}

}  // namespace

void add_nastran_bars(NastranBuild& build) {
  NastranModel& model = build.model;
  std::stable_partition(model.bars.begin(), model.bars.end(), [](const NastranBar& bar) { return !bar.rod; });
  for (NastranBar& bar : model.bars) {
    complete(bar, bar.beam ? model.beam_defaults : model.bar_defaults);
    const std::string name = fmt::format("element {}", bar.label);
    build.guarded(name, bar.place, [&] {
      const auto found = model.bar_properties.find(bar.property);
      if (found == model.bar_properties.end()) {
        const auto other = model.other_properties.find(bar.property);
        throw InputError(model.mark(bar.place), other == model.other_properties.end()
                                                    ? fmt::format("property {} is not there", bar.property)
                                                    : fmt::format("property {} is a {}, which is not read",
                                                                  bar.property, other->second));
      }
      NastranSection section = found->second.section;
      const std::vector<NastranStation>& stations = found->second.stations;
      const NastranMaterial& material = build.material(found->second.material, found->second.place);
      if (material.kind != NastranMaterial::Kind::isotropic)
        throw std::invalid_argument("a bar needs an isotropic material (MAT1)");
      if (!(section.area >= 0 && section.I1 >= 0 && section.I2 >= 0 && section.J >= 0))
        throw std::invalid_argument("its section's area and moments of area must not be negative");
      Placed place = placed(build, bar, name);
      if (!(place.length > 0)) return;  // reported already
      if (bar.rod) {
        section.I1 = section.I2 = section.I12 = 0;
      } else {
        if (!section.centroid.isZero(0))
          model.warn("shear centre", model.mark(found->second.place),
                     fmt::format("property {}: its section is taken to twist about the centroid, which lies "
                                 "{:.3g} off the shear centre: torsion and bending are not coupled",
                                 bar.property, section.centroid.norm()));
        to_centroids(build, place, stations.empty() ? section : stations.front().section,
                     stations.empty() ? section : stations.back().section);
        for (std::size_t end = 0; end < 2; ++end)
          if (bar.released[end] != 0) release(build, bar, end, name, place);
      }
      for (const int node : place.nodes) {
        char& turns = build.rotates[static_cast<std::size_t>(node)];
        if (!bar.rod) turns = 1;
        if (!turns) section.J = 0;  // nothing else would resist or pass on the twist of the rod
      }
      // Without any mass in the deck it has none yet: --density may give it.
      const bool massive = material.density * section.area + section.mass > 0 || !build.has_mass;
      const bool whole = is_whole(section) && material.young > 0 && material.shear > 0 &&
                         std::all_of(stations.begin(), stations.end(),
                                     [](const NastranStation& one) { return is_whole(one.section); });
      if (massive && whole && !bar.rod) {
        // Named in the mesh, too, so that a density can be given to it.
        build.mesh_material(fmt::format("MAT:{}", found->second.material),
                            {material.young, material.poisson, material.density * model.mass_factor},
                            std::nullopt);
        if (!stations.empty()) return add_tapered(build, place, stations, material);
        to_principal(section, place.axes);
        add_beam(build, place, section, material);
      } else {
        if (!stations.empty())
          model.warn(
              "taper", model.mark(found->second.place),
              "the section changes along the beam; without mass or some stiffness the mean of its ends "
              "is taken along each element");
        if (!bar.rod) to_principal(section, place.axes);
        add_by_springs(build, place, section, material, name);
      }
    });
  }
}

}  // namespace mimbre::fe
