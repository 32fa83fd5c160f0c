#pragma once
#include <cstddef>
#include <map>
#include <span>

#include "model_file/text/file_reader.h"

namespace mimbre::model_file {

/// The files of a model that was read once, for reading it again with other parameters where they are not
/// there. Blocks that FMUs compute are refused.
class KeptFiles : public FileReader {
 public:
  KeptFiles() = default;
  /// Those of bytes().
  explicit KeptFiles(std::span<const std::byte> bytes);
  std::vector<std::byte> bytes() const;

  std::shared_ptr<const Tree> model(const std::string& text, const std::string& name, const Limits& limits,
                                    std::vector<Diagnostic>& errors) const override;
  std::optional<Yaml> yaml(Builder& builder, const Value& value, const std::string& path) const override;
  std::shared_ptr<const ReducedBody> reduced_body(const std::string& path) const override;
  std::shared_ptr<const SurfaceMesh> surface(const std::string& path) const override;
  TyreProperties tyre(const std::string& path) const override;
  RoadGrid road(const std::string& path) const override;
  std::vector<Value> fmu_block(Builder& builder, const Fields& fields, spec::Block& block) const override;

 protected:
  // By path; all empty when made.
  mutable std::map<std::string, Yaml> yaml_;  ///< that of the model without its text
  mutable std::map<std::string, std::shared_ptr<const ReducedBody>> bodies_;
  mutable std::map<std::string, std::shared_ptr<const SurfaceMesh>> surfaces_;
  mutable std::map<std::string, TyreProperties> tyres_;
  mutable std::map<std::string, RoadGrid> roads_;
};

}  // namespace mimbre::model_file
