#pragma once
#include "mimbre/reduced_body.h"
#include "mimbre/spec.h"
#include "mimbre/surface_mesh.h"
#include "spec/archive.h"
#include "spec/function_parts.h"

/// The members of all that a model is made of. Each list names all members of its struct: with one more or
/// less the compiler refuses the structured binding.
namespace mimbre::archive {

// Functions.

template <class A>
void members(A& archive, Of<Function> auto& x) {
  FunctionParts::shared(archive, x);
}
template <class A>
void members(A& archive, Of<Formula> auto& x) {
  FunctionParts::shared(archive, x);
}
template <class A>
void members(A& archive, Of<FunctionData> auto& x) {
  FunctionParts::of(archive, x);
}
template <class A>
void members(A& archive, Of<Pieces> auto& x) {
  FunctionParts::of(archive, x);
}
template <class A>
void members(A& archive, Of<Expression> auto& x) {
  FunctionParts::of(archive, x);
}
template <class A>
void members(A& archive, Of<IntegralTable> auto& x) {
  FunctionParts::of(archive, x);
}
template <class A>
void members(A& archive, Of<ExpressionProgram::Instruction> auto& x) {
  auto& [op, at, number] = x;
  archive(op, at, number);
}
template <class A>
void members(A& archive, Of<OneVariable> auto& x) {
  auto& [expression, integral_start] = x;
  archive(expression, integral_start);
}
template <class A>
void members(A& archive, Of<IntegralFunction> auto& x) {
  auto& [f, start, exact, table] = x;
  archive(f, start, exact, table);
}

// Flexible bodies.

template <class A>
void members(A& archive, Of<BodyFrame> auto& x) {
  auto& [name, position, rotation, X, X_theta] = x;
  archive(name, position, rotation, X, X_theta);
}
template <class A>
void members(A& archive, Of<MeshInertia> auto& x) {
  auto& [dofs_per_node, mass, shapes, nodal_mass] = x;
  archive(dofs_per_node, mass, shapes, nodal_mass);
}
template <class A>
void members(A& archive, Of<SecondOrder> auto& x) {
  auto& [products, S, S_position, S_modes, mass_matrix, stiffness, frame_shapes, node_shapes, mesh_shapes] =
      x;
  archive(products, S, S_position, S_modes, mass_matrix, stiffness, frame_shapes, node_shapes, mesh_shapes);
}
template <class A>
void members(A& archive, Of<GeometricStiffness> auto& x) {
  auto& [loads, stiffness, boundary_loads] = x;
  archive(loads, stiffness, boundary_loads);
}
template <class A>
void members(A& archive, Of<Stretching> auto& x) {
  auto& [forms, places, stiffness, place_of_frame] = x;
  archive(forms, places, stiffness, place_of_frame);
}
template <class A>
void members(A& archive, Of<AncfBeam::Element> auto& x) {
  auto& [amplitudes, length, axial, bending] = x;
  archive(amplitudes, length, axial, bending);
}
template <class A>
void members(A& archive, Of<AncfBeam::SpatialElement> auto& x) {
  auto& [amplitudes, length, axial, bending_y, bending_z, torsion, shear_y, shear_z, section_shear] = x;
  archive(amplitudes, length, axial, bending_y, bending_z, torsion, shear_y, shear_z, section_shear);
}
template <class A>
void members(A& archive, Of<AncfBeam> auto& x) {
  auto& [kind, along, normal, elements, spatial, sections, stiffness_damping] = x;
  archive(kind, along, normal, elements, spatial, sections, stiffness_damping);
}
template <class A>
void members(A& archive, Of<BarSections::Section> auto& x) {
  auto& [position, axes, area, Iy, Iz, reach_y, reach_z, torsion_modulus, round, bar, element, along] = x;
  archive(position, axes, area, Iy, Iz, reach_y, reach_z, torsion_modulus, round, bar, element, along);
}
template <class A>
void members(A& archive, Of<BarSections> auto& x) {
  auto& [sections, influence] = x;
  archive(sections, influence);
}
template <class A>
void members(A& archive, Of<BarStress> auto& x) {
  auto& [round, shapes] = x;
  archive(round, shapes);
}
template <class A>
void members(A& archive, Of<Check> auto& x) {
  auto& [name, passed, detail] = x;
  archive(name, passed, detail);
}
template <class A>
void members(A& archive, Of<ReducedBody> auto& x) {
  auto& [name, modes, mode_names, mass, first_moment, second_moment, S, S_position, S_modes, mass_matrix,
         stiffness, damping, frames, boundary_rotation, user_from_modal, eigenfrequencies, nodes, node_shapes,
         lines, triangles, line_radius, node_labels, stress, strain, checks, second_order, geometric,
         stretching, ancf, sections, bar_stress, mesh_inertia] = x;
  archive(name, modes, mode_names, mass, first_moment, second_moment, S, S_position, S_modes, mass_matrix,
          stiffness, damping, frames, boundary_rotation, user_from_modal, eigenfrequencies, nodes,
          node_shapes, lines, triangles, line_radius, node_labels, stress, strain, checks, second_order,
          geometric, stretching, ancf, sections, bar_stress, mesh_inertia);
}

// Surfaces and roads.

template <class A>
void members(A& archive, Of<SurfaceMesh> auto& x) {
  auto& [vertices, triangles] = x;
  archive(vertices, triangles);
}
template <class A>
void members(A& archive, Of<RoadGrid> auto& x) {
  auto& [start_u, increment, along, across, line_height, bank, v, height, gaps, holes, right, left, unused] =
      x;
  archive(start_u, increment, along, across, line_height, bank, v, height, gaps, holes, right, left, unused);
}

// The model.

template <class A>
void members(A& archive, Of<Mark> auto& x) {
  auto& [file, line, column] = x;
  archive(file, line, column);
}
template <class A>
void members(A& archive, Of<spec::Pose> auto& x) {
  auto& [position, rotation] = x;
  archive(position, rotation);
}
template <class A>
void members(A& archive, Of<spec::Shape> auto& x) {
  auto& [kind, pose, size, mesh] = x;
  archive(kind, pose, size, mesh);
}
template <class A>
void members(A& archive, Of<InertiaTerms> auto& x) {
  auto& [bits] = x;
  archive(bits);
}
template <class A>
void members(A& archive, Of<spec::Body> auto& x) {
  auto& [name, mark, pose, mass, com, inertia, flexible, neglected, elastodynamic, shapes, lines] = x;
  archive(name, mark, pose, mass, com, inertia, flexible, neglected, elastodynamic, shapes, lines);
}
template <class A>
void members(A& archive, Of<spec::Frame> auto& x) {
  auto& [name, mark, body, pose, flexible_frame, node] = x;
  archive(name, mark, body, pose, flexible_frame, node);
}
template <class A>
void members(A& archive, Of<spec::Source> auto& x) {
  auto& [kind, index] = x;
  archive(kind, index);
}
template <class A>
void members(A& archive, Of<spec::Law> auto& x) {
  auto& [formula, arguments] = x;
  archive(formula, arguments);
}
template <class A>
void members(A& archive, Of<spec::Input> auto& x) {
  auto& [name, mark, unit, start, min, max, hold, tunable] = x;
  archive(name, mark, unit, start, min, max, hold, tunable);
}
template <class A>
void members(A& archive, Of<spec::Signal> auto& x) {
  auto& [name, mark, unit, law, every, named, block, output] = x;
  archive(name, mark, unit, law, every, named, block, output);
}
/// Without the code of blocks from elsewhere: model_bytes() refuses them.
template <class A>
void members(A& archive, Of<spec::Block> auto& x) {
  auto& [name, mark, type, inputs, numbers, matrices, function, every, outside] = x;
  static_cast<void>(outside);
  archive(name, mark, type, inputs, numbers, matrices, function, every);
}
template <class A>
void members(A& archive, Of<spec::Event::Set> auto& x) {
  auto& [input, value] = x;
  archive(input, value);
}
template <class A>
void members(A& archive, Of<spec::Event> auto& x) {
  auto& [name, mark, when, direction, sets, stop] = x;
  archive(name, mark, when, direction, sets, stop);
}
template <class A>
void members(A& archive, Of<spec::Drive> auto& x) {
  auto& [coordinate, law, of, signal] = x;
  archive(coordinate, law, of, signal);
}
template <class A>
void members(A& archive, Of<spec::JointSpring> auto& x) {
  auto& [coordinate, elastic, damping, general] = x;
  archive(coordinate, elastic, damping, general);
}
template <class A>
void members(A& archive, Of<spec::Joint> auto& x) {
  auto& [name, mark, type, frame_a, frame_b, cut, drives, springs, initial_position, initial_velocity, near,
         apart, elastic] = x;
  archive(name, mark, type, frame_a, frame_b, cut, drives, springs, initial_position, initial_velocity, near,
          apart, elastic);
}
template <class A>
void members(A& archive, Of<spec::Spring> auto& x) {
  auto& [name, mark, frame_a, frame_b, elastic, damping, general] = x;
  archive(name, mark, frame_a, frame_b, elastic, damping, general);
}
template <class A>
void members(A& archive, Of<spec::Load> auto& x) {
  auto& [name, mark, frame, force, moment, scale, follower, signal] = x;
  archive(name, mark, frame, force, moment, scale, follower, signal);
}
template <class A>
void members(A& archive, Of<spec::Road::Patch> auto& x) {
  auto& [low, high, friction] = x;
  archive(low, high, friction);
}
template <class A>
void members(A& archive, Of<spec::Road> auto& x) {
  auto& [name, mark, over, height, draw_from, draw_to, signal, heights, origin, spacing, along_line, friction,
         patches] = x;
  archive(name, mark, over, height, draw_from, draw_to, signal, heights, origin, spacing, along_line,
          friction, patches);
}
template <class A>
void members(A& archive, Of<spec::Tyre> auto& x) {
  auto& [name, mark, frame, road, stiffness, radius, law, axis, numbers] = x;
  archive(name, mark, frame, road, stiffness, radius, law, axis, numbers);
}
template <class A>
void members(A& archive, Of<spec::MaxwellBranch> auto& x) {
  auto& [stiffness, relaxation] = x;
  archive(stiffness, relaxation);
}
template <class A>
void members(A& archive, Of<spec::Element::Term> auto& x) {
  auto& [joint, coordinate, factor] = x;
  archive(joint, coordinate, factor);
}
/// Without the user's law, which is code: model_bytes() refuses it.
template <class A>
void members(A& archive, Of<spec::Element> auto& x) {
  auto& [name, mark, law, on, frame_a, frame_b, joint, coordinate, direction, about, terms, path, numbers,
         functions, arguments, general, branches, user] = x;
  static_cast<void>(user);
  archive(name, mark, law, on, frame_a, frame_b, joint, coordinate, direction, about, terms, path, numbers,
          functions, arguments, general, branches);
}
template <class A>
void members(A& archive, Of<spec::Constraint::Term> auto& x) {
  auto& [joint, coordinate, factor] = x;
  archive(joint, coordinate, factor);
}
template <class A>
void members(A& archive, Of<spec::Constraint> auto& x) {
  auto& [name, mark, type, terms, frame_a, frame_b, numbers, points, closed, road] = x;
  archive(name, mark, type, terms, frame_a, frame_b, numbers, points, closed, road);
}
template <class A>
void members(A& archive, Of<spec::Surface> auto& x) {
  auto& [name, mark, kind, frame, size, heights, spacing, vertices, triangles] = x;
  archive(name, mark, kind, frame, size, heights, spacing, vertices, triangles);
}
template <class A>
void members(A& archive, Of<spec::Spheres> auto& x) {
  auto& [frames, surface_of, radius] = x;
  archive(frames, surface_of, radius);
}
template <class A>
void members(A& archive, Of<spec::Contact> auto& x) {
  auto& [name, mark, spheres, surfaces, among, swarm, numbers] = x;
  archive(name, mark, spheres, surfaces, among, swarm, numbers);
}
template <class A>
void members(A& archive, Of<spec::Output> auto& x) {
  auto& [name, mark, kind, item, bodies, about, own_axes, component, reference, node, direction, offset] = x;
  archive(name, mark, kind, item, bodies, about, own_axes, component, reference, node, direction, offset);
}
template <class A>
void members(A& archive, Of<spec::Simulation> auto& x) {
  auto& [step, end, end_given, output_interval, formulation, inertia, formalism, integrator, rho, xi,
         tolerance, accuracy, penalty, max_iterations, substeps, energy_tolerance, fixed_cost,
         start_at_equilibrium] = x;
  archive(step, end, end_given, output_interval, formulation, inertia, formalism, integrator, rho, xi,
          tolerance, accuracy, penalty, max_iterations, substeps, energy_tolerance, fixed_cost,
          start_at_equilibrium);
}
template <class A>
void members(A& archive, Of<spec::Model> auto& x) {
  auto& [title, file, text, gravity, bodies, frames, joints, springs, loads, roads, tyres, elements,
         constraints, surfaces, contacts, inputs, signals, blocks, events, sensors, outputs, simulation] = x;
  archive(title, file, text, gravity, bodies, frames, joints, springs, loads, roads, tyres, elements,
          constraints, surfaces, contacts, inputs, signals, blocks, events, sensors, outputs, simulation);
}

}  // namespace mimbre::archive
