#include "mimbre/model_builder.h"

#include "mimbre/reduced_body.h"
#include "spec/check/check_spec.h"
#include "spec/model_builder_parts.h"

namespace mimbre {

Eigen::Matrix3d build::inertia(double xx, double yy, double zz, double xy, double xz, double yz) {
  Eigen::Matrix3d J;
  J << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  return J;
}

ModelBuilder::ModelBuilder(std::string title) : impl_(std::make_unique<Impl>()) {
  impl_->model.title = std::move(title);
}
ModelBuilder::ModelBuilder(const ModelBuilder& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
ModelBuilder::ModelBuilder(ModelBuilder&&) noexcept = default;
ModelBuilder& ModelBuilder::operator=(ModelBuilder other) noexcept {
  impl_ = std::move(other.impl_);
  return *this;
}
ModelBuilder::~ModelBuilder() = default;

void ModelBuilder::set_gravity(const Eigen::Vector3d& gravity) { impl_->model.gravity = gravity; }
void ModelBuilder::set_simulation(const spec::Simulation& simulation) {
  impl_->model.simulation = simulation;
}

namespace {

/// The body, and its own frame under the same name.
void keep(ModelBuilder::Impl& builder, Addition& addition, spec::Body body) {
  addition.new_body_frame(body.name, static_cast<int>(builder.model.bodies.size()));
  addition.commit(builder.bodies, builder.model.bodies.size());
  builder.model.bodies.push_back(std::move(body));
}

}  // namespace

void ModelBuilder::add_body(const std::string& name, const build::RigidBody& given) {
  Addition addition(*impl_, impl_->bodies, name);
  addition.coordinates_of(given.in);
  spec::Body body;
  body.name = name;
  body.pose = addition.pose(given.at.value_or(given.com), given.axes);
  body.mass = given.mass;
  body.com = body.pose.rotation.transpose() * (addition.point("com", given.com) - body.pose.position);
  body.inertia = given.inertia;
  body.shapes = given.shapes;
  body.lines = given.lines;
  keep(*impl_, addition, std::move(body));
}

void ModelBuilder::add_flexible_body(const std::string& name, std::shared_ptr<const ReducedBody> reduced,
                                     const build::FlexibleBody& place) {
  Addition addition(*impl_, impl_->bodies, name);
  if (!reduced) addition.refuse("there is no reduced body; make one with fe::reduce or load_reduced_body");
  addition.coordinates_of(place.in);
  spec::Body body;
  body.name = name;
  body.pose = addition.pose(place.at, place.axes);
  body.flexible = std::move(reduced);
  body.neglected = place.neglected;
  body.elastodynamic = place.elastodynamic;
  body.shapes = place.shapes;
  keep(*impl_, addition, std::move(body));
}

void ModelBuilder::add_frame(const std::string& name, const build::Frame& given) {
  Addition addition(*impl_, impl_->frames, name);
  addition.coordinates_of(given.in);
  const Attachment on = addition.attachment("on", given.on);
  if (on.frame >= 0) addition.refuse(fmt::format("on: '{}' is a frame; name its body", given.on));
  const int number = addition.new_frame(name, on.body, addition.pose(given.at, given.axes));
  addition.commit(impl_->frames, static_cast<std::size_t>(number));
}

spec::Model ModelBuilder::build() const {
  check_spec(impl_->model);
  return impl_->model;
}

std::shared_ptr<const Model> ModelBuilder::compile() const { return Model::compile(impl_->model); }

}  // namespace mimbre
