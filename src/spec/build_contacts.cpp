#include "spec/model_builder_parts.h"

/// Surfaces and contacts by names.
namespace mimbre {

void ModelBuilder::add_surface(const std::string& name, const build::Surface& given) {
  Addition addition(*impl_, impl_->surfaces, name);
  addition.coordinates_of(given.in);
  spec::Surface surface;
  surface.name = name;
  surface.kind = given.kind;
  surface.size = given.size;
  surface.heights = given.heights;
  surface.spacing = given.spacing;
  surface.vertices = given.vertices;
  surface.triangles = given.triangles;
  const Attachment on = addition.attachment("on", given.on);
  surface.frame = on.frame;
  if (on.frame < 0) {
    spec::Pose pose = addition.pose(given.at.value_or(Eigen::Vector3d::Zero()), given.axes);
    if (!given.at && on.body >= 0) pose.position = addition.body_pose(on.body).position;
    surface.frame = addition.new_frame(name + ".surface", on.body, pose);
  } else if (given.at || given.axes.x || given.axes.y || given.axes.z) {
    addition.refuse(fmt::format("'{}' is a frame, which has its place and axes already", given.on));
  }
  addition.commit(impl_->surfaces, impl_->model.surfaces.size());
  impl_->model.surfaces.push_back(std::move(surface));
}

void ModelBuilder::add_contact(const std::string& name, const build::Contact& given) {
  Addition addition(*impl_, impl_->contacts, name);
  addition.coordinates_of(given.in);
  spec::Contact contact;
  contact.name = name;
  contact.among = given.among;
  contact.swarm = given.swarm;
  int number = 0;
  for (const build::Spheres& set : given.spheres) {
    spec::Spheres spheres;
    spheres.radius = set.radius;
    if (!set.surface_of.empty()) {
      if (!set.on.empty()) addition.refuse("spheres: give 'on' or 'surface_of', not both");
      spheres.surface_of = addition.find(impl_->bodies, "surface_of", set.surface_of);
    } else if (set.at.empty()) {
      spheres.frames = {addition.attach("on", set.on, {}, name)};
    } else {
      for (const Eigen::Vector3d& at : set.at)
        spheres.frames.push_back(
            addition.attach("on", set.on, at, fmt::format("{}.sphere{}", name, number++)));
    }
    contact.spheres.push_back(std::move(spheres));
  }
  for (const std::string& surface : given.surfaces)
    contact.surfaces.push_back(addition.find(impl_->surfaces, "surface", surface));
  contact.numbers = {given.stiffness, given.exponent,     given.depth,    given.restitution,
                     given.friction,  given.static_ratio, given.stribeck, given.tangential,
                     given.settling,  given.rolling,      given.spinning};
  addition.commit(impl_->contacts, impl_->model.contacts.size());
  impl_->model.contacts.push_back(std::move(contact));
}

}  // namespace mimbre
