#include "urdf/merged.h"

namespace mimbre::urdf {
namespace {

/// Adds a link's mass and inertia, of which one may be 0; the body's inertia is in global axes meanwhile.
void add_mass(MergedBody& body, const Link& link, const Pose& place) {
  const Eigen::Vector3d com = place.position + place.rotation * link.com;
  const double mass = body.mass + link.mass;
  const Eigen::Vector3d centre =
      mass > 0 ? Eigen::Vector3d((body.mass * body.com + link.mass * com) / mass) : body.com;
  body.inertia += place.rotation * link.inertia * place.rotation.transpose() +
                  steiner(body.mass, body.com - centre) + steiner(link.mass, com - centre);
  body.mass = mass;
  body.com = centre;
}

}  // namespace

Eigen::Matrix3d steiner(double mass, const Eigen::Vector3d& arm) {
  return mass * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
}

MergedRobot merged(const Robot& robot, bool keep_fixed) {
  MergedRobot result;
  result.body_of.assign(robot.links.size(), -1);
  result.links.resize(robot.links.size());
  for (const int index : robot.order) {
    const auto l = static_cast<std::size_t>(index);
    const Link& link = robot.links[l];
    const Joint* joint =
        robot.held_by[l] < 0 ? nullptr : &robot.joints[static_cast<std::size_t>(robot.held_by[l])];
    if (joint) result.links[l] = result.links[static_cast<std::size_t>(joint->parent)].of(joint->pose);
    const bool merges = joint && joint->type == Joint::Type::fixed && !keep_fixed;
    result.body_of[l] = merges ? result.body_of[static_cast<std::size_t>(joint->parent)]
                               : static_cast<int>(result.bodies.size());
    if (!merges) {
      MergedBody body;
      body.link = index;
      body.pose = result.links[l];
      body.com = body.pose.position;
      result.bodies.push_back(body);
    }
    MergedBody& body = result.bodies[static_cast<std::size_t>(result.body_of[l])];
    if (merges) body.frames.push_back(index);
    // Inertia without mass turns with what carries it, whether the link stays a body or not.
    const bool massless_inertia = link.mass == 0 && !link.inertia.isZero(0);
    const bool held = joint && joint->type == Joint::Type::fixed;
    MergedBody& moved =
        massless_inertia && held
            ? result.bodies[static_cast<std::size_t>(result.body_of[static_cast<std::size_t>(joint->parent)])]
            : body;
    if (link.mass > 0 || massless_inertia) add_mass(moved, link, result.links[l]);
    const auto place = [&](const std::vector<Visual>& from, std::vector<Visual>& to) {
      for (Visual shape : from) {
        shape.pose = result.links[l].of(shape.pose);
        to.push_back(shape);
      }
    };
    place(link.visuals, body.visuals);
    place(link.collisions, body.collisions);
  }
  for (MergedBody& body : result.bodies)
    body.inertia = body.pose.rotation.transpose() * body.inertia * body.pose.rotation;
  return result;
}

}  // namespace mimbre::urdf
