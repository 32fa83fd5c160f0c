#include "model_file/surface_files.h"

namespace mimbre::model_file {

std::shared_ptr<const SurfaceMesh> read_surface_file(Builder& builder, const Value& value) {
  const auto path = value.word();
  if (!path) return nullptr;
  if (!has_folder(builder, value)) return nullptr;
  const std::string file = path_of(builder, value.mark(), *path);
  const auto [known, fresh] = builder.surfaces.try_emplace(file);
  if (!fresh) return known->second;
  builder.other_files.push_back(file);
  try {
    known->second = std::make_shared<const SurfaceMesh>(read_surface_mesh(file));
  } catch (const InputError& e) {
    for (const Diagnostic& d : e.diagnostics()) value.error(to_string(d));
  }
  return known->second;
}

Eigen::Vector3d read_scale(const Fields& fields) {
  const auto scale = fields.get("scale");
  if (!scale) return Eigen::Vector3d::Ones();
  const Eigen::Vector3d factors =
      scale->is_list() ? scale->triple().value_or(Eigen::Vector3d::Ones())
                       : Eigen::Vector3d(Eigen::Vector3d::Constant(scale->number().value_or(1)));
  if ((factors.array() != 0).all()) return factors;
  scale->error("is 0; a mesh in millimetres has scale: 0.001");
  return Eigen::Vector3d::Ones();
}

}  // namespace mimbre::model_file
