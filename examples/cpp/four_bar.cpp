#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <string>

#include "mimbre/beam_reduction.h"
#include "mimbre/model_builder.h"
#include "mimbre/simulation.h"

using Eigen::Vector3d;
using mimbre::spec::JointType;

/// A round steel bar of this length along x, held at its first node, that bends in its x–z plane.
std::shared_ptr<const mimbre::ReducedBody> steel_bar(double length) {
  constexpr int elements = 10;
  const double area = std::numbers::pi / 4 * 0.008 * 0.008, I = std::numbers::pi / 64 * std::pow(0.008, 4);
  mimbre::fe::Mesh mesh;
  mesh.nodes = Eigen::Matrix3Xd::Zero(3, elements + 1);
  mesh.nodes.row(0).setLinSpaced(elements + 1, 0, length);
  for (int k = 0; k < elements; ++k) {
    mimbre::fe::BeamElement bar;
    bar.nodes = {k, k + 1};
    bar.section = {area, I, I, 2 * I};
    bar.material = {2.1e11, 0.3, 7850};
    mesh.elements.push_back(bar);
  }

  mimbre::fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.boundary = {{elements, false, Vector3d::UnitX(), "axial"},
                      {elements, false, Vector3d::UnitZ(), "transverse"}};
  options.dynamic_modes = 2;
  options.stiffness_damping = 1e-5;
  for (int k = 1; k <= elements; ++k)
    for (const int dof : {1, 3, 5})  // along y, about x, about z
      options.fixed_dofs.push_back(6 * k + dof);
  return std::make_shared<const mimbre::ReducedBody>(
      mimbre::fe::reduce(mesh, options, {{"crank", 0}, {"rocker", elements}, {"middle", elements / 2}}));
}

std::shared_ptr<const mimbre::Model> four_bar() {
  using mimbre::build::inertia;
  mimbre::ModelBuilder m("Four-bar linkage with a flexible coupler");
  m.add_body("crank", {.mass = 0.5, .com = {0, 0, 0.1}, .inertia = inertia(0.002, 0.002, 0.0001)});
  m.add_flexible_body("coupler", steel_bar(std::hypot(0.6, 0.3)),
                      {.at = {0, 0, 0.2}, .axes = {.x = Vector3d{0.6, 0, 0.3}, .y = Vector3d{0, 1, 0}}});
  m.add_body("rocker", {.mass = 1, .com = {0.6, 0, 0.25}, .inertia = inertia(0.02, 0.02, 0.0005)});

  const Vector3d y{0, 1, 0};
  m.add_joint("motor",
              {.type = JointType::revolute,
               .between = {"ground", "crank"},
               .at = Vector3d{0, 0, 0},
               .axis = y,
               .drives = {{.law = mimbre::Function::expression("2*pi*(t - 0.5*(1 - exp(-2*t)))", "t")}}});
  m.add_joint(
      "crank_pin",
      {.type = JointType::revolute, .between = {"crank", "coupler"}, .at = Vector3d{0, 0, 0.2}, .axis = y});
  m.add_joint(
      "pivot",
      {.type = JointType::revolute, .between = {"ground", "rocker"}, .at = Vector3d{0.6, 0, 0}, .axis = y});
  m.add_joint("rocker_pin", {.type = JointType::revolute,
                             .between = {"coupler", "rocker"},
                             .at = Vector3d{0.6, 0, 0.5},
                             .axis = y});

  m.add_output("rocker", {.kind = "joint", .of = "pivot"});
  const Vector3d across{-0.3, 0, 0.6};
  m.add_output("middle", {.kind = "deflection", .of = "coupler.middle", .along = across});
  m.add_output("end", {.kind = "deflection", .of = "coupler.rocker", .along = across});
  m.set_simulation({.step = 0.001, .end = 5});
  return m.compile();
}

int main() {
  try {
    mimbre::Simulation simulation(four_bar());
    const auto channel = [&](const std::string& name) {
      const auto& all = simulation.channels();
      return std::find_if(all.begin(), all.end(), [&](const auto& c) { return c.name == name; }) -
             all.begin();
    };
    const auto rocker = channel("rocker"), middle = channel("middle"), end = channel("end");
    mimbre::ResultsRow row;
    double least = 0, most = 0, sag = 0;
    for (int k = 0; k < 5000; ++k) {
      const mimbre::StepReport report = simulation.step();
      if (!report.ok()) return std::fputs(simulation.explain(report).c_str(), stderr), 1;
      simulation.sample(row);
      least = std::min(least, row.channels[rocker]);
      most = std::max(most, row.channels[rocker]);
      sag = std::max(sag, std::abs(row.channels[middle] - row.channels[end] / 2));
    }
    std::printf("the rocker swings from %.2f to %.2f rad\n", least, most);
    std::printf("the coupler sags by up to %.1f mm\n", 1e3 * sag);
  } catch (const mimbre::InputError& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
