#include "portable/library/record_source.h"

#include <filesystem>

#include "mimbre/model_bytes.h"
#include "model_file/text/kept_files.h"
#include "model_file/text/parse.h"

namespace mimbre::portable {
namespace {

/// Reads from the disk, and keeps what it has read.
class KeepingFiles final : public model_file::KeptFiles {
 public:
  std::shared_ptr<const model_file::Tree> model(const std::string& text, const std::string& name,
                                                const model_file::Limits& limits,
                                                std::vector<Diagnostic>& errors) const override {
    auto tree = model_file::disk_files().model(text, name, limits, errors);
    yaml_[name] = {"", tree};
    return tree;
  }
  std::optional<Yaml> yaml(model_file::Builder& builder, const model_file::Value& value,
                           const std::string& path) const override {
    auto read = model_file::disk_files().yaml(builder, value, path);
    if (read && read->tree) yaml_[path] = *read;
    return read;
  }
  std::shared_ptr<const ReducedBody> reduced_body(const std::string& path) const override {
    return bodies_[path] = model_file::disk_files().reduced_body(path);
  }
  std::shared_ptr<const SurfaceMesh> surface(const std::string& path) const override {
    return surfaces_[path] = model_file::disk_files().surface(path);
  }
  TyreProperties tyre(const std::string& path) const override {
    return tyres_[path] = model_file::disk_files().tyre(path);
  }
  RoadGrid road(const std::string& path) const override {
    return roads_[path] = model_file::disk_files().road(path);
  }
};

}  // namespace

std::optional<ModelSource> source_of(const spec::Model& model,
                                     const std::map<std::string, std::string>& settings) {
  if (model.text.empty()) return {};
  ModelSource out;
  out.text = model.text;
  out.file = model.file;
  out.directory = std::filesystem::path(model.file).parent_path().string();
  if (out.directory.empty()) out.directory = ".";
  out.settings = settings;
  try {
    const KeepingFiles files;
    std::vector<model_file::DeclaredParameter> declared;
    spec::Model again = model_file::parse_by(files, out.text, out.file, out.directory, settings, nullptr, {},
                                             nullptr, &declared);
    // What was included stands behind the text already.
    again.text = model.text;
    if (model_bytes(again) != model_bytes(model)) return {};
    out.parameters = fixed_parameters(declared);
    out.simulation = again.simulation;
    out.files = files.bytes();
  } catch (const InputError&) {
    return {};
  }
  return out;
}

}  // namespace mimbre::portable
