#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mimbre/reduced_body.h"
#include "mimbre/road_file.h"
#include "mimbre/surface_mesh.h"
#include "mimbre/tyre_file.h"
#include "model_file/text/builder.h"

namespace mimbre::model_file {

/// How the files of a model are read: from the disk, or from what was read before (kept_files.h). Functions
/// that return a file's contents throw InputError where it cannot be read.
class FileReader {
 public:
  virtual ~FileReader() = default;

  /// parse_yaml() of the model file itself, called `name`.
  virtual std::shared_ptr<const Tree> model(const std::string& text, const std::string& name,
                                            const Limits& limits, std::vector<Diagnostic>& errors) const = 0;
  /// Of a further YAML file. Nothing, and an error at `value`, where there is none.
  struct Yaml {
    std::string text;
    std::shared_ptr<const Tree> tree;
  };
  virtual std::optional<Yaml> yaml(Builder& builder, const Value& value, const std::string& path) const = 0;
  virtual std::shared_ptr<const ReducedBody> reduced_body(const std::string& path) const = 0;
  virtual std::shared_ptr<const SurfaceMesh> surface(const std::string& path) const = 0;
  virtual TyreProperties tyre(const std::string& path) const = 0;
  virtual RoadGrid road(const std::string& path) const = 0;
  /// A block that an FMU computes, as read_fmu() describes it.
  virtual std::vector<Value> fmu_block(Builder& builder, const Fields& fields, spec::Block& block) const = 0;
};

/// Reads from the disk.
const FileReader& disk_files();

}  // namespace mimbre::model_file
