#include "model_file/sections/fmu_block.h"
#include "model_file/text/file_reader.h"

namespace mimbre::model_file {
namespace {

class DiskFiles final : public FileReader {
 public:
  std::shared_ptr<const Tree> model(const std::string& text, const std::string& name, const Limits& limits,
                                    std::vector<Diagnostic>& errors) const override {
    return parse_yaml(text, name, limits, errors);
  }
  std::optional<Yaml> yaml(Builder& builder, const Value& value, const std::string& path) const override {
    std::optional<std::string> text = read_file(builder, value, path);
    if (!text) return {};
    auto tree = parse_yaml(*text, path, builder.limits, builder.errors.list);
    return Yaml{std::move(*text), std::move(tree)};
  }
  std::shared_ptr<const ReducedBody> reduced_body(const std::string& path) const override {
    return std::make_shared<const ReducedBody>(load_reduced_body(path));
  }
  std::shared_ptr<const SurfaceMesh> surface(const std::string& path) const override {
    return std::make_shared<const SurfaceMesh>(read_surface_mesh(path));
  }
  TyreProperties tyre(const std::string& path) const override { return read_tyre_properties(path); }
  RoadGrid road(const std::string& path) const override { return read_road_grid(path); }
  std::vector<Value> fmu_block(Builder& builder, const Fields& fields, spec::Block& block) const override {
    return read_fmu(builder, fields, block);
  }
};

}  // namespace

const FileReader& disk_files() {
  static const DiskFiles files;
  return files;
}

}  // namespace mimbre::model_file
