#pragma once
#include <Eigen/Geometry>
#include <numbers>

#include "mimbre/beam_reduction.h"

/// Meshes and numbers shared by the finite-element and reduction tests.
namespace mimbre::test {

fe::Material steel();

fe::Section rectangle(double width, double height);

fe::Section round_bar(double diameter);

/// Adds `elements` equal elements from one node to another.
void add_bar(fe::Mesh& mesh, int from, int to, int elements, const fe::Section& section,
             const Eigen::Vector3d& y_direction = Eigen::Vector3d::Zero());

fe::Mesh with_nodes(std::initializer_list<Eigen::Vector3d> nodes);

/// Along x from the origin; node 0 is the root, node 1 the tip; section y along body y.
fe::Mesh straight_beam(double length, int elements, const fe::Section& section);

/// Turned by R, then moved by t.
fe::Mesh moved(fe::Mesh mesh, const Eigen::Matrix3d& R, const Eigen::Vector3d& t);

Eigen::Matrix3d some_rotation();

/// Two bars that meet at an angle out of the coordinate planes, the joining element rigidly offset at its
/// ends.
fe::Mesh bent_frame();

/// The six unit rigid motions (translations, rotations about the origin) in nodal dofs.
Eigen::MatrixXd rigid_motions(const fe::Mesh& mesh);

}  // namespace mimbre::test
