#include "urdf/repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "math/once/decompositions.h"
#include "urdf/merged.h"
#include "urdf/yaml_text.h"

namespace mimbre::urdf {
namespace {

constexpr double density = 1000, of_box = 0.5;        ///< kg/m³; the share of its box that a mesh fills
constexpr double ball_size = 0.05, ball_mass = 1e-3;  ///< of the robot's
constexpr double least_moment = 1e-3;                 ///< of the largest principal second moment of mass
constexpr double rounding = 1e-6;                     ///< of figures in files

struct Solid {
  double mass = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about com; axes as com's
};

Solid box_of(const Eigen::Vector3d& edges, double of_density) {
  Solid solid;
  solid.mass = of_density * std::abs(edges.x() * edges.y() * edges.z());
  const Eigen::Vector3d squares = edges.cwiseAbs2();
  solid.inertia.diagonal() =
      solid.mass / 12 *
      Eigen::Vector3d(squares.y() + squares.z(), squares.x() + squares.z(), squares.x() + squares.y());
  return solid;
}

Solid cylinder_of(double radius, double length) {
  Solid solid;
  solid.mass = density * EIGEN_PI * radius * radius * length;
  const double across = solid.mass * (radius * radius / 4 + length * length / 12);
  solid.inertia.diagonal() = Eigen::Vector3d(across, across, solid.mass * radius * radius / 2);
  return solid;
}

Solid ball_of(double mass, double radius) {
  Solid solid;
  solid.mass = mass;
  solid.inertia = 0.4 * mass * radius * radius * Eigen::Matrix3d::Identity();
  return solid;
}

/// A cylinder and two half balls.
Solid capsule_of(double radius, double length) {
  Solid solid = cylinder_of(radius, length);
  const double half = density * 2 * EIGEN_PI / 3 * radius * radius * radius;
  const double centre = 3 * radius / 8, arm = length / 2 + centre;
  const double own = half * radius * radius * (0.4 - 9.0 / 64);
  const double across = 2 * (own + half * arm * arm);
  solid.inertia += Eigen::Vector3d(across, across, 2 * 0.4 * half * radius * radius).asDiagonal();
  solid.mass += 2 * half;
  return solid;
}

Solid solid_of(const Visual& shape, const MeshBox& box) {
  const Eigen::Vector3d& size = shape.size;
  switch (shape.kind) {
    case Visual::Kind::box:
      return box_of(size, density);
    case Visual::Kind::cylinder:
      return cylinder_of(size[0], size[1]);
    case Visual::Kind::sphere:
      return ball_of(density * 4 * EIGEN_PI / 3 * size[0] * size[0] * size[0], size[0]);
    case Visual::Kind::capsule:
      return capsule_of(size[0], size[1]);
    case Visual::Kind::mesh:
      break;
  }
  const auto corners = box(shape);
  if (!corners) return {};
  Solid solid = box_of((corners->second - corners->first).cwiseProduct(size), of_box * density);
  solid.com = (0.5 * (corners->first + corners->second)).cwiseProduct(size);
  return solid;
}

/// Of all shapes together, in global axes.
Solid sum(const std::vector<Visual>& shapes, const MeshBox& box) {
  Solid all;
  for (const Visual& shape : shapes) {
    const Solid one = solid_of(shape, box);
    if (!(one.mass > 0) || !std::isfinite(one.mass)) continue;
    const Eigen::Matrix3d& R = shape.pose.rotation;
    const Eigen::Vector3d com = shape.pose.position + R * one.com;
    const double mass = all.mass + one.mass;
    const Eigen::Vector3d centre = (all.mass * all.com + one.mass * com) / mass;
    all.inertia += R * one.inertia * R.transpose() + steiner(all.mass, all.com - centre) +
                   steiner(one.mass, com - centre);
    all.mass = mass, all.com = centre;
  }
  return all;
}

class Repair {
 public:
  Repair(const Robot& robot, MergedRobot& merged, bool floating, const MeshBox& box)
      : robot_(robot), merged_(merged), tree_(robot, merged, floating), box_(box) {
    for (const MergedBody& body : merged.bodies) mass_ += body.mass;
  }

  std::vector<Diagnostic> all(std::size_t first) {
    for (std::size_t k = first; k < merged_.bodies.size(); ++k) {
      MergedBody& body = merged_.bodies[k];
      if (!is_possible(body.inertia))
        change(body, "the nearest that matter can have",
               [&] { body.inertia = possible_inertia(body.inertia); });
      if (body.mass == 0 && moves(body)) {
        const Solid solid = shapes_of(body);
        if (solid.mass > 0)
          fill(body, solid);
        else if (!body.inertia.isZero(0))  // which the model cannot have without mass
          fill(body, ball());
      }
      if (body.mass > 0 && body.inertia.isZero(0)) {
        const Solid& solid = shapes_of(body);
        spread(body, solid.mass > 0 ? solid : ball());
      }
    }
    tree_.find_massless_motions([&](std::size_t k) {
      MergedBody& body = merged_.bodies[k];
      if (k < first) return false;
      const Solid solid = shapes_of(body);
      if (body.mass == 0)
        fill(body, solid.mass > 0 ? solid : ball());
      else
        spread(body, solid.mass > 0 ? solid : ball());
      return true;
    });
    return std::move(list_);
  }

 private:
  bool moves(const MergedBody& body) const {
    const int holder = robot_.held_by[static_cast<std::size_t>(body.link)];
    return holder >= 0 && robot_.joints[static_cast<std::size_t>(holder)].type != Joint::Type::fixed;
  }
  const Solid& shapes_of(const MergedBody& body) {
    const auto number = static_cast<std::size_t>(&body - merged_.bodies.data());
    if (solids_.size() <= number) solids_.resize(merged_.bodies.size());
    auto& known = solids_[number];
    if (!known) {
      known = sum(body.visuals, box_);
      if (!(known->mass > 0)) known = sum(body.collisions, box_);
    }
    return *known;
  }
  /// Of a body without shapes.
  Solid ball() const {
    const double radius = ball_size * (tree_.size() > 0 ? tree_.size() : 1);
    return ball_of(mass_ > 0 ? ball_mass * mass_ : density * 4 * EIGEN_PI / 3 * radius * radius * radius,
                   radius);
  }
  std::string way(const MergedBody& body) {
    return shapes_of(body).mass > 0
               ? fmt::format("its shapes at {} kg/m³, meshes as boxes at {}", density, of_box * density)
               : "a ball, since it has no shapes";
  }

  /// Mass, and inertia where it has none.
  void fill(MergedBody& body, const Solid& solid) {
    change(body, way(body), [&] {
      const Eigen::Matrix3d& R = body.pose.rotation;
      body.mass = solid.mass;
      body.com = shapes_of(body).mass > 0 ? solid.com : body.pose.position;
      if (body.inertia.isZero(0)) body.inertia = R.transpose() * solid.inertia * R;
    });
  }
  /// Inertia, as the solid's of that mass.
  void spread(MergedBody& body, const Solid& solid) {
    change(body, way(body), [&] {
      const Eigen::Matrix3d& R = body.pose.rotation;
      body.inertia = body.mass / solid.mass * (R.transpose() * solid.inertia * R);
    });
  }

  template <class Make>
  void change(MergedBody& body, const std::string& how, const Make& make) {
    const double mass = body.mass;
    const Eigen::Vector3d moments = eigenvalues3(body.inertia);
    make();
    const Link& link = robot_.links[static_cast<std::size_t>(body.link)];
    std::string text = fmt::format("link '{}': ", link.name);
    if (body.mass != mass) text += fmt::format("mass {:.4g} is {:.4g} kg, ", mass, body.mass);
    const auto three = [](const Eigen::Vector3d& I) {
      return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", I[0] + 0.0, I[1] + 0.0, I[2] + 0.0);
    };
    text += fmt::format("principal moments {} are {} kg m²: {}", three(moments),
                        three(eigenvalues3(body.inertia)), how);
    list_.push_back({link.mark, text});
  }

  const Robot& robot_;
  MergedRobot& merged_;
  BodyTree tree_;
  const MeshBox& box_;
  double mass_ = 0;  ///< of the robot as its file has it
  std::vector<std::optional<Solid>> solids_;
  std::vector<Diagnostic> list_;
};

}  // namespace

bool is_possible(const Eigen::Matrix3d& inertia) {
  if (inertia.isZero(0)) return true;
  const Eigen::Vector3d I = eigenvalues3(inertia);
  return I[0] > 1e-12 * I[2] && I[0] + I[1] >= I[2] * (1 - rounding);
}

Eigen::Matrix3d possible_inertia(const Eigen::Matrix3d& inertia) {
  if (is_possible(inertia)) return inertia;
  const EigenPairs pairs = symmetric_eigen(inertia);
  const Eigen::Vector3d axes = pairs.values;
  Eigen::Vector3d s = Eigen::Vector3d::Constant(0.5 * (axes[0] + axes[1] + axes[2])) - axes;
  const double largest = s.maxCoeff();
  if (!(largest > 0)) return Eigen::Matrix3d::Zero();  // as of a point
  s = s.cwiseMax(least_moment * largest);
  const Eigen::Vector3d I(s[1] + s[2], s[0] + s[2], s[0] + s[1]);
  const Eigen::Matrix3d V = pairs.vectors, J = V * I.asDiagonal() * V.transpose();
  return 0.5 * (J + J.transpose());
}

std::vector<Diagnostic> repair(const Robot& robot, MergedRobot& merged, bool floating, std::size_t first,
                               const MeshBox& box) {
  return Repair(robot, merged, floating, box).all(first);
}

std::vector<Diagnostic> faults(const Robot& robot, const MergedRobot& merged, bool floating,
                               std::size_t first) {
  std::vector<Diagnostic> list;
  const auto link = [&](std::size_t k) -> const Link& {
    return robot.links[static_cast<std::size_t>(merged.bodies[k].link)];
  };
  for (std::size_t k = first; k < merged.bodies.size(); ++k) {
    const MergedBody& body = merged.bodies[k];
    if (!is_possible(body.inertia) || (body.mass > 0 && body.inertia.isZero(0)))
      list.push_back({link(k).mark,
                      fmt::format("link '{}': no matter has the principal moments {}; the model is refused "
                                  "until they are right, unless its joints make them harmless",
                                  link(k).name, urdf::list(eigenvalues3(body.inertia)))});
    else if (body.mass == 0 && !body.inertia.isZero(0))
      list.push_back({link(k).mark, fmt::format("link '{}' has inertia but no mass; the model is refused "
                                                "until it has both or none",
                                                link(k).name)});
  }
  BodyTree(robot, merged, floating).find_massless_motions([&](std::size_t k) {
    if (k < first) return false;
    list.push_back(
        {link(k).mark,
         merged.bodies[k].mass == 0
             ? fmt::format("link '{}' moves but has no mass: give it some before the model can run",
                           link(k).name)
             : fmt::format("link '{}' moves in a direction in which it has no inertia: give it some before "
                           "the model can run",
                           link(k).name)});
    return false;
  });
  return list;
}

}  // namespace mimbre::urdf
