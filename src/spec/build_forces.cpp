#include "spec/model_builder_parts.h"
#include "spec/road_height.h"

/// Springs, loads, roads and tyres by names.
namespace mimbre {

void ModelBuilder::add_spring(const std::string& name, const build::Spring& given) {
  Addition addition(*impl_, impl_->springs, name);
  addition.coordinates_of(given.in);
  spec::Spring spring;
  spring.name = name;
  spring.frame_a = addition.attach("between", given.between[0], given.at[0], name + ".a");
  spring.frame_b = addition.attach("between", given.between[1], given.at[1], name + ".b");
  spring.elastic = given.elastic;
  spring.damping = given.damping;
  if (!given.force.is_zero()) spring.general = {given.force, {spec::Source{}}};
  addition.commit(impl_->springs, impl_->model.springs.size());
  impl_->model.springs.push_back(std::move(spring));
}

void ModelBuilder::add_load(const std::string& name, const build::Load& given) {
  Addition addition(*impl_, impl_->loads, name);
  addition.coordinates_of(given.in);
  spec::Load load;
  load.name = name;
  load.frame = addition.attach("on", given.on, given.at, name + ".frame");
  load.force = addition.vector(given.force);
  load.moment = addition.vector(given.moment);
  load.scale = given.scale;
  load.follower = given.follower;
  if (load.follower) {  // given in the assembled position; from there on it turns with the frame
    const Eigen::Matrix3d axes = addition.frame_pose(load.frame).rotation;
    load.force = (axes.transpose() * load.force).eval();
    load.moment = (axes.transpose() * load.moment).eval();
  }
  addition.commit(impl_->loads, impl_->model.loads.size());
  impl_->model.loads.push_back(std::move(load));
}

void ModelBuilder::add_road(const std::string& name, const build::Road& given) {
  Addition addition(*impl_, impl_->roads, name);
  spec::Road road;
  road.name = name;
  road.over = given.over;
  road.friction = given.friction;
  road.patches = given.patches;
  road.heights = given.heights;
  road.origin = given.origin;
  road.spacing = given.spacing;
  road.along_line = given.along_line;
  if (given.over == spec::Road::Over::grid) {
    addition.commit(impl_->roads, impl_->model.roads.size());
    impl_->model.roads.push_back(std::move(road));
    return;
  }
  if (given.points.size() < 2) addition.refuse("at least two points are needed");
  std::vector<double> x, z;
  for (const auto& point : given.points) {
    x.push_back(point[0]);
    z.push_back(point[1]);
  }
  road.draw_from = x.front();
  road.draw_to = x.back();
  const double length = road.draw_to - road.draw_from;
  if (given.repeat && *given.repeat < length * (1 - 1e-12))
    addition.refuse(fmt::format("repeat {} is shorter than the points reach ({})", *given.repeat, length));
  try {
    road.height = road_height(std::move(x), std::move(z), given.repeat);
  } catch (const InputError& error) {  // which does not know of whose points it speaks
    addition.refuse(error.diagnostics().front().message);
  }
  addition.commit(impl_->roads, impl_->model.roads.size());
  impl_->model.roads.push_back(std::move(road));
}

void ModelBuilder::add_tyre(const std::string& name, const build::Tyre& given) {
  Addition addition(*impl_, impl_->tyres, name);
  addition.coordinates_of(given.in);
  spec::Tyre tyre;
  tyre.name = name;
  tyre.frame = addition.attach("on", given.on, given.at, name + ".frame");
  tyre.road = addition.find(impl_->roads, "road", given.road);
  tyre.stiffness = given.stiffness;
  tyre.radius = given.radius;
  tyre.law = given.law;
  tyre.numbers = given.numbers;
  tyre.axis = tyre.frame < 0 ? given.axis
                             : Eigen::Vector3d(addition.frame_pose(tyre.frame).rotation.transpose() *
                                               addition.vector(given.axis));
  addition.commit(impl_->tyres, impl_->model.tyres.size());
  impl_->model.tyres.push_back(std::move(tyre));
}

}  // namespace mimbre
