#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "fe_files/nastran/nastran_build.h"

// S. J. Garvey, The quadrilateral shear panel (Aircraft Engineering 1951).

namespace mimbre::fe {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Forces at the corners that are in balance, and how far a unit of them deforms the panel by G t.
struct Shear {
  std::array<Vector3d, 4> forces;
  double flexibility = 0;
  double area = 0;
};

/// Forces along the sides of the panel's projection, of which three conditions of balance leave one; at
/// corners beside that plane forces along the normal balance their moments.
Shear shear_of(const std::array<Vector3d, 4>& x, double poisson) {
  const Vector3d middle = (x[0] + x[1] + x[2] + x[3]) / 4;
  const Vector3d across = (x[2] - x[0]).cross(x[3] - x[1]);
  const double size = (x[2] - x[0]).norm() + (x[3] - x[1]).norm();
  if (!(across.norm() > 1e-9 * size * size)) throw std::invalid_argument("has no area");
  Matrix3d axes;
  axes.col(2) = across.normalized();
  axes.col(0) = (x[2] - x[0]).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  std::array<Vector3d, 4> p, side;
  for (std::size_t k = 0; k < 4; ++k) p[k] = axes.transpose() * (x[k] - middle);
  Eigen::Matrix<double, 3, 4> balance;  // forces along x and y, moment, by the force of each side
  std::array<double, 4> length{};
  for (std::size_t k = 0; k < 4; ++k) {
    side[k] = p[(k + 1) % 4] - p[k];
    side[k].z() = 0;
    length[k] = side[k].norm();
    if (!(length[k] > 1e-9 * size)) throw std::invalid_argument("has a side without length");
    side[k] /= length[k];
    balance.col(static_cast<Eigen::Index>(k)) << side[k].x(), side[k].y(), p[k].cross(side[k]).z() / size;
  }
  Shear shear;
  shear.area = across.norm() / 2;
  double squares = 0;
  for (std::size_t k = 0; k < 4; ++k) shear.forces[k].setZero();
  for (std::size_t k = 0; k < 4; ++k) {
    Matrix3d others;
    for (std::size_t j = 0, column = 0; j < 4; ++j)
      if (j != k) others.col(static_cast<Eigen::Index>(column++)) = balance.col(static_cast<Eigen::Index>(j));
    const double force = (k % 2 == 0 ? 1 : -1) * others.determinant();
    squares += std::pow(force / length[k], 2) / 4;
    shear.forces[k] += force / 2 * side[k];
    shear.forces[(k + 1) % 4] += force / 2 * side[k];
  }
  if (!(squares * size * size > 1e-20)) throw std::invalid_argument("its sides carry no shear");
  Vector3d moment = Vector3d::Zero();
  Eigen::Matrix<double, 3, 4> lift;
  for (std::size_t k = 0; k < 4; ++k) {
    moment += Vector3d(0, 0, p[k].z()).cross(shear.forces[k]);
    // Σ w = 0, Σ y w = −Mx, Σ −x w = −My
    lift.col(static_cast<Eigen::Index>(k)) << size, p[k].y(), -p[k].x();
  }
  const Eigen::Vector4d normal =
      lift.transpose() * (lift * lift.transpose()).inverse() * Vector3d(0, -moment.x(), -moment.y());
  for (std::size_t k = 0; k < 4; ++k)
    shear.forces[k] = axes * (shear.forces[k] + Vector3d(0, 0, normal[static_cast<Eigen::Index>(k)]));
  const Vector3d r = p[1] + p[2] - p[0] - p[3], s = p[2] + p[3] - p[0] - p[1];
  const double cosine = r.dot(s) / (r.norm() * s.norm()), skew = cosine * cosine / (1 - cosine * cosine);
  shear.flexibility = shear.area * squares * (1 + 2 / (1 + poisson) * skew);
  return shear;
}

/// What of the panel carries normal forces: rods along opposite sides. Up to 1.01 the factor is the share of
/// the sheet, above it half the width of sheet, in thicknesses, that goes with each side.
void add_rods(NastranBuild& build, const std::string& name, const std::array<int, 4>& nodes, double young,
              const NastranPanelProperty& property, double panel_area) {
  constexpr double largest_share = 1.01;
  const auto side = [&](std::size_t k) -> Vector3d {
    return build.at(nodes[(k + 1) % 4]) - build.at(nodes[k]);
  };
  for (std::size_t k = 0; k < 4; ++k) {
    const double factor = property.rods[k % 2], length = side(k).norm();
    if (factor == 0) continue;
    const double width = factor > largest_share ? factor * property.thickness / 2
                                                : factor * panel_area / (length + side((k + 2) % 4).norm());
    Spring rod{name, young * width * property.thickness / length, {}};
    NastranBuild::add_translation(nodes[(k + 1) % 4], side(k) / length, Vector3d::Zero(), 1, rod.stretch);
    NastranBuild::add_translation(nodes[k], side(k) / length, Vector3d::Zero(), -1, rod.stretch);
    build.tidy(rod.stretch, true);
    build.mesh.springs.push_back(std::move(rod));
  }
}

}  // namespace

void add_nastran_panels(NastranBuild& build) {
  NastranModel& model = build.model;
  for (const NastranPanel& panel : model.panels) {
    const std::string name = fmt::format("CSHEAR {}", panel.label);
    build.guarded(name, panel.place, [&] {
      const auto found = model.panel_properties.find(panel.property);
      if (found == model.panel_properties.end())
        throw std::invalid_argument(fmt::format("property {} is not there", panel.property));
      const NastranPanelProperty& property = found->second;
      const NastranMaterial& material = build.material(property.material, property.place);
      std::array<int, 4> nodes{};
      std::array<Vector3d, 4> places;
      for (std::size_t k = 0; k < 4; ++k) {
        nodes[k] = build.node(panel.nodes[k], panel.place, name);
        if (nodes[k] < 0) return;
        places[k] = build.at(nodes[k]);
      }
      const Shear shear = shear_of(places, material.poisson);
      Spring spring;
      spring.name = name;
      spring.stiffness = material.shear * property.thickness / shear.flexibility;
      for (std::size_t k = 0; k < 4; ++k)
        for (int d = 0; d < 3; ++d) spring.stretch.push_back({nodes[k], d, shear.forces[k][d]});
      build.tidy(spring.stretch, true);
      build.mesh.springs.push_back(std::move(spring));
      add_rods(build, name, nodes, material.young, property, shear.area);
      const double mass =
          (material.density * property.thickness + property.mass) * shear.area * model.mass_factor;
      if (mass > 0)
        for (const int node : nodes)
          build.mesh.point_masses.push_back({name, node, mass / 4, Matrix3d::Zero(), Vector3d::Zero()});
    });
  }
}

}  // namespace mimbre::fe
