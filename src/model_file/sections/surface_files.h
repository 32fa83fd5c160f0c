#pragma once
#include <Eigen/Core>
#include <memory>

#include "mimbre/surface_mesh.h"
#include "model_file/text/builder.h"

namespace mimbre::model_file {

/// The surface of the file that is named, read once for a model; nothing where that is wrong, which is
/// reported.
std::shared_ptr<const SurfaceMesh> read_surface_file(Builder& builder, const Value& name);

/// Likewise of a surface that is only drawn: where the file is there and cannot be read, that is a warning,
/// and there is nothing to draw.
std::shared_ptr<const SurfaceMesh> read_drawn_file(Builder& builder, const Value& name);

/// `scale`: factors on a mesh's coordinates, one, or one for each of its axes; default: 1.
Eigen::Vector3d read_scale(const Fields& fields);

}  // namespace mimbre::model_file
