#include "fe/meshes.h"

namespace mimbre::test {

fe::Material steel() { return {2.1e11, 0.3, 7850}; }

fe::Section rectangle(double width, double height) {
  return {width * height, width * std::pow(height, 3) / 12, std::pow(width, 3) * height / 12,
          0.2 * width * std::pow(height, 3)};
}

fe::Section round_bar(double diameter) {
  const double r = diameter / 2;
  const double I = std::numbers::pi * std::pow(r, 4) / 4;
  return {std::numbers::pi * r * r, I, I, 2 * I};
}

void add_bar(fe::Mesh& mesh, int from, int to, int elements, const fe::Section& section,
             const Eigen::Vector3d& y_direction) {
  const Eigen::Vector3d a = mesh.nodes.col(from);
  const Eigen::Vector3d b = mesh.nodes.col(to);
  int previous = from;
  for (int e = 1; e <= elements; ++e) {
    int next = to;
    if (e < elements) {
      next = static_cast<int>(mesh.nodes.cols());
      mesh.nodes.conservativeResize(3, next + 1);
      mesh.nodes.col(next) = a + (b - a) * e / elements;
    }
    fe::BeamElement element;
    element.nodes = {previous, next};
    element.y_direction = y_direction;
    element.section = section;
    element.material = steel();
    mesh.elements.push_back(element);
    previous = next;
  }
}

fe::Mesh with_nodes(std::initializer_list<Eigen::Vector3d> nodes) {
  fe::Mesh mesh;
  mesh.nodes.resize(3, static_cast<Eigen::Index>(nodes.size()));
  Eigen::Index i = 0;
  for (const Eigen::Vector3d& node : nodes) mesh.nodes.col(i++) = node;
  return mesh;
}

fe::Mesh straight_beam(double length, int elements, const fe::Section& section) {
  fe::Mesh mesh = with_nodes({Eigen::Vector3d::Zero(), {length, 0, 0}});
  add_bar(mesh, 0, 1, elements, section, Eigen::Vector3d::UnitY());
  return mesh;
}

fe::Mesh moved(fe::Mesh mesh, const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  mesh.nodes = ((R * mesh.nodes).colwise() + t).eval();
  for (fe::BeamElement& element : mesh.elements) {
    for (auto& offset : element.offsets) offset = (R * offset).eval();
    element.y_direction = (R * element.y_direction).eval();
  }
  return mesh;
}

Eigen::Matrix3d some_rotation() {
  return Eigen::AngleAxisd(1.1, Eigen::Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
}

fe::Mesh bent_frame() {
  fe::Mesh mesh = with_nodes({{0.1, 0.2, -0.1}, {1.0, 0.4, 0.3}, {1.3, -0.5, 0.9}});
  add_bar(mesh, 0, 1, 4, rectangle(0.03, 0.02), {0.1, 0.2, 1});
  add_bar(mesh, 1, 2, 3, rectangle(0.025, 0.015), {0.3, 0.1, 1});
  mesh.elements[3].offsets[1] = {0.01, -0.04, 0.03};
  mesh.elements[4].offsets[0] = {-0.02, 0.05, 0.01};
  return mesh;
}

Eigen::MatrixXd rigid_motions(const fe::Mesh& mesh) {
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(6 * mesh.nodes.cols(), 6);
  for (Eigen::Index node = 0; node < mesh.nodes.cols(); ++node) {
    const Eigen::Vector3d r = mesh.nodes.col(node);
    motions.block<6, 6>(6 * node, 0).setIdentity();
    for (int k = 0; k < 3; ++k) motions.block<3, 1>(6 * node, 3 + k) = Eigen::Vector3d::Unit(k).cross(r);
  }
  return motions;
}

}  // namespace mimbre::test
