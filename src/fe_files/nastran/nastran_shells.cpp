#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "fe_files/nastran/nastran_build.h"
#include "math/once/decompositions.h"

// MSC Nastran Quick Reference Guide, PSHELL and PCOMP; classical theory of laminates (R. M. Jones, Mechanics
// of Composite Materials).

namespace mimbre::fe {

namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSame = 1e-9;       ///< of shares that count as equal
constexpr double kSymmetric = 1e-6;  ///< of a laminate's coupling against its stiffness

/// Forces by strain, moments by curvature, of a shell by its length; mass by its area.
struct Resultants {
  Matrix3d membrane = Matrix3d::Zero(), coupling = Matrix3d::Zero(), bending = Matrix3d::Zero();
  Matrix2d shear = Matrix2d::Zero();  ///< zx, yz
  double mass = 0, rotary = 0;        ///< rotary: ∫ ρ z² dz
  bool isotropic = false;
  const NastranMaterial* material = nullptr;  ///< what stands for checks
};

Matrix3d in_plane(const NastranMaterial& m) {
  if (m.kind == NastranMaterial::Kind::sheet) return m.sheet;
  if (m.kind == NastranMaterial::Kind::solid)
    throw std::invalid_argument("its material is that of a solid; a shell needs MAT1, MAT2 or MAT8");
  Matrix3d Q;
  Q << 1, m.poisson, 0, m.poisson, 1, 0, 0, 0, 0;
  Q *= m.young / (1 - m.poisson * m.poisson);
  Q(2, 2) = m.shear;
  return Q;
}

Matrix2d across(const NastranMaterial& m) {
  return m.kind == NastranMaterial::Kind::sheet ? m.sheet_shear : Matrix2d(m.shear * Matrix2d::Identity());
}

bool is_plain(const NastranMaterial& m) {
  return m.kind == NastranMaterial::Kind::isotropic && m.poisson < 0.5 && m.poisson > -1 &&
         std::abs(m.shear - m.young / (2 * (1 + m.poisson))) <= 1e-6 * m.shear;
}

/// In directions turned by `angle`, anticlockwise, from the material's.
Matrix3d turned(const Matrix3d& Q, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Matrix3d strain;  // in the material's directions, of that in the shell's
  strain << c * c, s * s, c * s, s * s, c * c, -c * s, -2 * c * s, 2 * c * s, c * c - s * s;
  return strain.transpose() * Q * strain;
}

Matrix2d turned(const Matrix2d& G, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  Matrix2d strain;
  strain << c, s, -s, c;
  return strain.transpose() * G * strain;
}

Resultants of_laminate(const NastranBuild& build, const NastranShellProperty& property) {
  Resultants r;
  double z = -property.thickness / 2;
  Matrix2d compliance = Matrix2d::Zero();
  for (const NastranShellProperty::Ply& ply : property.plies) {
    const NastranMaterial& material = build.material(ply.material, property.place);
    const double angle = ply.angle * std::numbers::pi / 180, top = z + ply.thickness;
    const Matrix3d Q = turned(in_plane(material), angle);
    const double third = (std::pow(top, 3) - std::pow(z, 3)) / 3;
    r.membrane += ply.thickness * Q;
    r.coupling += (top * top - z * z) / 2 * Q;
    r.bending += third * Q;
    compliance += ply.thickness * turned(Matrix2d(across(material).inverse()), angle);
    r.mass += material.density * ply.thickness;
    r.rotary += material.density * third;
    if (!r.material) r.material = &material;
    z = top;
  }
  // Plies in series: the same shear force through all.
  r.shear = 5.0 / 6 * property.thickness * property.thickness * compliance.inverse();
  return r;
}

Resultants of_plain(const NastranBuild& build, const NastranShellProperty& p, double thickness,
                    NastranModel& model, const std::string& name) {
  if (!(thickness > 0)) throw std::invalid_argument("has no thickness");
  Resultants r;
  const NastranMaterial& membrane = build.material(p.membrane > 0 ? p.membrane : p.bending, p.place);
  const NastranMaterial& bending = build.material(p.bending > 0 ? p.bending : p.membrane, p.place);
  const NastranMaterial& shear = p.shear > 0 ? build.material(p.shear, p.place) : bending;
  const bool alone = p.shear > 0 && shear.kind == NastranMaterial::Kind::sheet;
  if (p.bending == 0 || p.membrane == 0)
    model.warn("MID2", model.mark(p.place),
               fmt::format("{}: has stiffness {} only; that of the same material and thickness is added",
                           name, p.bending == 0 ? "in its plane" : "in bending"));
  if (p.coupling > 0 && p.coupling != p.membrane)
    throw std::invalid_argument("coupling of membrane and bending (MID4) is not read");
  const double inertia = p.bending_ratio * std::pow(thickness, 3) / 12;
  r.membrane = thickness * in_plane(membrane);
  r.bending = inertia * in_plane(bending);
  r.shear = p.shear_ratio * thickness * (alone ? shear.shear_alone : across(shear));
  r.mass = membrane.density * thickness;
  r.rotary = membrane.density * std::pow(thickness, 3) / 12;
  r.isotropic = is_plain(membrane) && &membrane == &bending && &membrane == &shear && p.bending_ratio == 1 &&
                std::abs(p.shear_ratio - 5.0 / 6) < 1e-4;
  r.material = &membrane;
  return r;
}

/// A homogeneous sheet.
struct Layer {
  double thickness = 0, density = 0;
  double offset = 0;  ///< of its middle from that of the shell
  std::optional<ElasticMatrix> elastic;
};

ElasticMatrix elastic_of(const Matrix3d& Q, const Matrix2d& G) {
  ElasticMatrix C = ElasticMatrix::Zero();
  constexpr int plane[] = {0, 1, 3};  // xx yy xy
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) C(plane[i], plane[j]) = Q(i, j);
  C(2, 2) = std::max(Q(0, 0), Q(1, 1));  // across nothing is stressed
  constexpr int shear[] = {5, 4};        // zx, yz
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) C(shear[i], shear[j]) = G(i, j);
  return 0.5 * (C + C.transpose());
}

/// Homogeneous sheets on the same nodes whose stiffness against stretching, bending and shear is together
/// that of the shell: one where bending is that of some thickness, else two, one thinner and one thicker than
/// all that the bending asks for, which always exist.
std::vector<Layer> layers(const Resultants& r, double thickness) {
  if (r.isotropic) return {{thickness, r.mass / thickness, 0, std::nullopt}};
  const double ratio = (r.membrane.transpose() * r.bending).trace() / r.membrane.squaredNorm();
  if ((r.bending - ratio * r.membrane).norm() <= kSame * r.bending.norm()) {
    const double t = std::sqrt(12 * ratio);
    return {{t, r.mass / t, 0, elastic_of(r.membrane / t, r.shear / (5.0 / 6 * t))}};
  }
  // 12 D x = t² A x: thicknesses by themselves.
  const Eigen::VectorXd squares = symmetric_eigenvalues(12 * r.bending, r.membrane);
  if (squares.size() != 3 || !(squares[0] > 0)) throw std::invalid_argument("its stiffness is not positive");
  const double thin = squares[0] / 2, thick = squares[2] * 2;  // t²
  const double t[] = {std::sqrt(thin), std::sqrt(thick)};
  const Matrix3d outer = (12 * r.bending - thin * r.membrane) / (thick - thin);  // t Q of the thick one
  const Matrix3d inner = r.membrane - outer;
  const double share = outer.trace() * thick / (outer.trace() * thick + inner.trace() * thin);
  // Mass such that rotary inertia is right, too, where that can be.
  const double wanted = r.mass > 0 ? (12 * r.rotary / r.mass - thin) / (thick - thin) : 0.5;
  const double heavy = std::clamp(wanted, 0.01, 0.99);
  return {{t[0], (1 - heavy) * r.mass / t[0], 0,
           elastic_of(inner / t[0], (1 - share) * r.shear / (5.0 / 6 * t[0]))},
          {t[1], heavy * r.mass / t[1], 0, elastic_of(outer / t[1], share * r.shear / (5.0 / 6 * t[1]))}};
}

/// A laminate that is not symmetric about its middle: each ply is a sheet of its own, beside the nodes.
std::vector<Layer> plies(const NastranBuild& build, const NastranShellProperty& property) {
  std::vector<Layer> result;
  double z = -property.thickness / 2;
  for (const NastranShellProperty::Ply& ply : property.plies) {
    const NastranMaterial& material = build.material(ply.material, property.place);
    const double angle = ply.angle * std::numbers::pi / 180;
    result.push_back({ply.thickness, material.density, z + ply.thickness / 2,
                      elastic_of(turned(in_plane(material), angle), turned(across(material), angle))});
    z += ply.thickness;
  }
  return result;
}

struct ShellGroup {
  std::vector<int> indices;  ///< of the mesh's groups, one for each layer
  bool directed = false;
};

using Key = std::tuple<ElementType, std::int64_t, double, double>;  // property, thickness, offset

ShellGroup new_group(NastranBuild& build, const NastranShell& shell, ElementType type, double thickness,
                     double offset) {
  NastranModel& model = build.model;
  const auto found = model.shell_properties.find(shell.property);
  const NastranShellProperty& property = found->second;
  const bool laminate = !property.plies.empty();
  const std::string name = fmt::format("{}:{}", laminate ? "PCOMP" : "PSHELL", shell.property);
  const Resultants resultants =
      laminate ? of_laminate(build, property) : of_plain(build, property, thickness, model, name);
  const double bent = std::sqrt(resultants.membrane.norm() * resultants.bending.norm());
  const bool symmetric = resultants.coupling.norm() <= kSymmetric * bent;
  ShellGroup group;
  group.directed = !resultants.isotropic;
  const std::vector<Layer> made = symmetric ? layers(resultants, thickness) : plies(build, property);
  for (std::size_t i = 0; i < made.size(); ++i) {
    const NastranMaterial& material = *resultants.material;
    ElementGroup one;
    one.type = type;
    one.name = name;
    one.thickness = made[i].thickness;
    one.offset = offset + made[i].offset;
    one.reduced_integration = type == ElementType::quad8;  // with full integration thin ones lock
    const double by_volume = property.mass / static_cast<double>(made.size()) / made[i].thickness;
    one.material = build.mesh_material(
        resultants.isotropic && property.mass == 0
            ? fmt::format("MAT:{}", property.membrane > 0 ? property.membrane : property.bending)
            : fmt::format("{} t={} layer {}", name, thickness, i + 1),
        {material.young, made[i].elastic ? 0 : material.poisson,
         (made[i].density + by_volume) * model.mass_factor},
        made[i].elastic);
    group.indices.push_back(static_cast<int>(build.mesh.groups.size()));
    build.mesh.groups.push_back(std::move(one));
  }
  if (made.size() > 1)
    model.warn(
        "stress " + name, model.mark(property.place),
        fmt::format(
            "{}: its stiffness is that of several sheets on the same nodes; stress in it has no meaning",
            name));
  return group;
}

/// Mean over the corners; those without a thickness of their own have the property's.
double thickness_of(const NastranShell& shell, const NastranShellProperty& property, NastranModel& model) {
  const int corners = shell.type == ElementType::tri3 || shell.type == ElementType::tri6 ? 3 : 4;
  double sum = 0, least = INFINITY, most = 0;
  for (int i = 0; i < corners; ++i) {
    double one = shell.thickness[static_cast<std::size_t>(i)];
    if (shell.relative_thickness && one > 0) one *= property.thickness;
    if (!(one > 0)) one = property.thickness;
    sum += one;
    least = std::min(least, one);
    most = std::max(most, one);
  }
  if (most > least)
    model.warn("corner thickness", model.mark(shell.place),
               fmt::format("element {}: its thickness changes from corner to corner; the mean is taken",
                           shell.label));
  return most > least ? sum / corners : most;
}

Vector3d normal_of(const NastranBuild& build, ElementType type, const std::vector<int>& nodes) {
  const auto x = [&](std::size_t i) { return build.at(nodes[i]); };
  const bool triangle = type == ElementType::tri3 || type == ElementType::tri6;
  const Vector3d normal =
      triangle ? (x(1) - x(0)).cross(x(2) - x(0)).eval() : (x(2) - x(0)).cross(x(3) - x(1)).eval();
  return normal.normalized();
}

Orientation orientation_of(const NastranBuild& build, const NastranShell& shell,
                           const std::vector<int>& nodes) {
  Orientation orientation;
  const Vector3d normal = normal_of(build, shell.type, nodes);
  Vector3d first;
  if (shell.system) {
    const bool triangle = shell.type == ElementType::tri3 || shell.type == ElementType::tri6;
    Vector3d centre = Vector3d::Zero();
    for (std::size_t i = 0; i < (triangle ? 3u : 4u); ++i) centre += build.at(nodes[i]) / (triangle ? 3 : 4);
    const Matrix3d axes =
        build.model.systems.at(*shell.system, build.model.mark(shell.place)).directions(centre);
    // Where x is across the shell its projection has no meaning.
    first = std::abs(axes.col(0).dot(normal)) < 0.9999 ? axes.col(0) : axes.col(1);
  } else {
    first = build.at(nodes[1]) - build.at(nodes[0]);
  }
  first -= normal.dot(first) * normal;
  if (!(first.norm() > 1e-6 * (shell.system ? 1.0 : (build.at(nodes[1]) - build.at(nodes[0])).norm())))
    throw std::invalid_argument("the direction of its material is across the shell");
  first.normalize();
  if (!shell.system) {
    const double angle = shell.angle * std::numbers::pi / 180;
    first = std::cos(angle) * first + std::sin(angle) * normal.cross(first);
  }
  orientation.axes << first, normal.cross(first), normal;
  return orientation;
}

/// A card's shell in the mesh: elements of one type.
struct Pieces {
  ElementType type = ElementType::tri3;
  std::vector<std::vector<int>> nodes;
};

/// Triangles that fill the polygon of `round` from `first` to `last`, and the quality of the worst: of all
/// ways the one where that is best.
std::pair<double, std::vector<std::vector<int>>> triangles(const NastranBuild& build,
                                                           const std::vector<int>& round, std::size_t first,
                                                           std::size_t last) {
  std::pair<double, std::vector<std::vector<int>>> best{-1, {}};
  if (last - first < 2) return {INFINITY, {}};
  for (std::size_t k = first + 1; k < last; ++k) {
    const Vector3d a = build.at(round[first]), b = build.at(round[k]), c = build.at(round[last]);
    const double sides = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
    auto [before, all] = triangles(build, round, first, k);
    auto [behind, more] = triangles(build, round, k, last);
    const double worst = std::min({before, behind, sides > 0 ? (b - a).cross(c - b).norm() / sides : 0.0});
    if (worst <= best.first * (1 + 1e-9)) continue;
    all.insert(all.end(), more.begin(), more.end());
    all.push_back({round[first], round[k], round[last]});
    best = {worst, std::move(all)};
  }
  return best;
}

/// `nodes` of the card, −1 amid sides that have none. Curved triangles lock where they are thin, and a node
/// that follows the ends of its side cannot bend: such elements become flat triangles, which do neither.
Pieces pieces_of(const NastranBuild& build, ElementType type, const std::vector<int>& nodes) {
  const std::size_t corners = type == ElementType::tri3 || type == ElementType::tri6 ? 3 : 4;
  std::vector<int> round;
  for (std::size_t i = 0; i < corners; ++i) {
    round.push_back(nodes[i]);
    if (nodes.size() > corners && nodes[corners + i] >= 0) round.push_back(nodes[corners + i]);
  }
  if (corners == 4 && round.size() == nodes.size()) return {type, {nodes}};
  if (corners == 4 && round.size() == corners) return {ElementType::quad4, {round}};
  if (round.size() == 6 && corners == 3)
    return {ElementType::tri3,
            {{round[0], round[1], round[5]},
             {round[1], round[2], round[3]},
             {round[3], round[4], round[5]},
             {round[1], round[3], round[5]}}};
  return {ElementType::tri3, triangles(build, round, 0, round.size() - 1).second};
}

}  // namespace

void add_nastran_shells(NastranBuild& build) {
  NastranModel& model = build.model;
  std::map<Key, ShellGroup> groups;
  for (const NastranShell& shell : model.shells) {
    const std::string name = fmt::format("element {}", shell.label);
    build.guarded(name, shell.place, [&] {
      const auto found = model.shell_properties.find(shell.property);
      if (found == model.shell_properties.end()) {
        const auto other = model.other_properties.find(shell.property);
        throw InputError(
            model.mark(shell.place),
            other == model.other_properties.end()
                ? fmt::format("property {} is not there", shell.property)
                : fmt::format("property {} is a {}, which is not read", shell.property, other->second));
      }
      const int count = node_count(shell.type);
      std::vector<int> nodes(static_cast<std::size_t>(count), -1);
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        const std::int64_t label = model.element_nodes[shell.first + i];
        if (label == 0) continue;
        nodes[i] = build.node(label, shell.place, name);
        if (nodes[i] < 0) return;
        build.rotates[static_cast<std::size_t>(nodes[i])] = 1;
      }
      const Pieces pieces = pieces_of(build, shell.type, nodes);
      const NastranShellProperty& property = found->second;
      const bool laminate = !property.plies.empty();
      const double thickness = laminate ? property.thickness : thickness_of(shell, property, model);
      const double offset = laminate ? property.bottom + property.thickness / 2 + shell.offset.value_or(0)
                                     : shell.offset.value_or(0);
      const auto [place, is_new] = groups.try_emplace(Key(pieces.type, shell.property, thickness, offset));
      if (is_new) place->second = new_group(build, shell, pieces.type, thickness, offset);
      const ShellGroup& group = place->second;
      if (group.indices.empty()) return;  // reported already
      int orientation = -1;
      if (group.directed) {
        orientation = static_cast<int>(build.mesh.orientations.size());
        build.mesh.orientations.push_back(orientation_of(build, shell, nodes));
      }
      for (const int index : group.indices) {
        ElementGroup& made = build.mesh.groups[static_cast<std::size_t>(index)];
        for (const std::vector<int>& piece : pieces.nodes) {
          made.nodes.insert(made.nodes.end(), piece.begin(), piece.end());
          made.labels.push_back(shell.label);
          if (orientation >= 0) made.orientations.push_back(orientation);
        }
      }
    });
  }
}

}  // namespace mimbre::fe
