#pragma once
#include <Eigen/Core>

#include "mimbre/fe_mesh.h"

/// Isoparametric shape functions of the solid elements, nodes numbered as in Abaqus and CalculiX.
namespace mimbre::fe {

constexpr int kMaxSolidNodes = 20;
/// With the modes that no node has (incompatible modes of the 8-node brick).
constexpr int kMaxGradients = 20;

using NodePositions = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxSolidNodes>;
using ShapeValues = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxGradients, 1>;
using ShapeGradients = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxGradients>;

/// 3 × nodes, in reference coordinates.
NodePositions reference_nodes(ElementType type);

/// Value of every node's function at a point of the reference element.
ShapeValues shape_values(ElementType type, const Eigen::Vector3d& at);

/// Derivatives by the reference coordinates, a column per node.
ShapeGradients shape_gradients(ElementType type, const Eigen::Vector3d& at);

}  // namespace mimbre::fe
