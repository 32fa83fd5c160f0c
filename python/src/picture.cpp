#include "picture.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <utility>

#include "mimbre/simulation.h"

/// Bodies as lines, for pictures of a moment.
namespace mimbre::python {
namespace {

/// Ends of lines, one pair after the other, in the axes of a body.
using Ends = std::vector<Eigen::Vector3d>;

void add_circle(Ends& ends, const spec::Pose& pose, double radius, double height, int normal) {
  constexpr int parts = 24;
  const auto at = [&](int k) {
    const double angle = 2 * std::numbers::pi * k / parts;
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    p[(normal + 1) % 3] = radius * std::cos(angle);
    p[(normal + 2) % 3] = radius * std::sin(angle);
    p[normal] = height;
    return Eigen::Vector3d(pose.position + pose.rotation * p);
  };
  for (int k = 0; k < parts; ++k) ends.insert(ends.end(), {at(k), at(k + 1)});
}

void add_shape(Ends& ends, const spec::Shape& shape) {
  using Kind = spec::Shape::Kind;
  if (shape.kind == Kind::sphere) {
    for (int normal = 0; normal < 3; ++normal) add_circle(ends, shape.pose, shape.size[0], 0, normal);
  } else if (shape.kind == Kind::cylinder) {
    for (const double side : {-0.5, 0.5})
      add_circle(ends, shape.pose, shape.size[0], side * shape.size[1], 2);
  } else {
    for (int corner = 0; corner < 8; ++corner)
      for (int axis = 0; axis < 3; ++axis) {
        if (corner & 1 << axis) continue;
        for (const int end : {corner, corner | 1 << axis}) {
          const Eigen::Vector3d p(end & 1 ? 0.5 : -0.5, end & 2 ? 0.5 : -0.5, end & 4 ? 0.5 : -0.5);
          ends.push_back(shape.pose.position + shape.pose.rotation * p.cwiseProduct(shape.size));
        }
      }
  }
}

}  // namespace

Picture picture(Simulation& simulation, const ResultsHeader& header) {
  ResultsRow row;
  simulation.sample(row);
  Picture lines;
  Eigen::Index first = 0;
  for (std::size_t b = 0; b < header.bodies.size(); ++b) {
    const BodyDrawing& body = header.bodies[b];
    const Eigen::VectorXd amplitudes = row.modes.segment(first, body.modes);
    first += body.modes;
    Eigen::Matrix3Xd points = body.points;
    if (body.modes > 0) points.reshaped() += body.point_shapes * amplitudes;
    Ends ends;
    for (const auto& [from, to] : body.lines) ends.insert(ends.end(), {points.col(from), points.col(to)});
    for (const auto& [p, q, r] : body.triangles)
      for (const auto& [from, to] : {std::pair(p, q), std::pair(q, r), std::pair(r, p)})
        if (from < to) ends.insert(ends.end(), {points.col(from), points.col(to)});
    // What has no lines of its own is seen by where others take hold of it.
    const bool bare = ends.empty() && body.shapes.empty();
    for (const FrameDrawing& frame : header.frames)
      if (bare && frame.body == static_cast<int>(b))
        ends.insert(ends.end(), {Eigen::Vector3d::Zero(), frame.pose.position});
    for (const spec::Shape& shape : body.shapes) add_shape(ends, shape);
    const auto pose = row.poses.col(static_cast<Eigen::Index>(b));
    const Eigen::Quaterniond turn(pose[3], pose[4], pose[5], pose[6]);
    Eigen::MatrixXd global(static_cast<Eigen::Index>(ends.size()), 3);
    for (std::size_t k = 0; k < ends.size(); ++k)
      global.row(static_cast<Eigen::Index>(k)) = (pose.head<3>() + turn * ends[k]).transpose();
    lines.emplace_back(body.name, std::move(global));
  }
  return lines;
}

}  // namespace mimbre::python
