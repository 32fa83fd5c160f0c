#pragma once
#include <map>
#include <string>
#include <vector>

#include "mimbre/spec.h"
#include "model_file/text/file_reader.h"
#include "model_file/text/limits.h"
#include "model_file/text/parameters.h"

namespace mimbre::model_file {

/// parse_model with bounds of its own: what fuzzing calls, so that no input is slow.
spec::Model parse(const std::string& text, const std::string& name, const std::string& directory,
                  const std::map<std::string, std::string>& overrides, std::vector<Diagnostic>* warnings,
                  const Limits& limits, std::vector<std::string>* other_files = nullptr);

/// The same of files that `files` reads. `parameters` (optional) receives those of the model, in their order.
spec::Model parse_by(const FileReader& files, const std::string& text, const std::string& name,
                     const std::string& directory, const std::map<std::string, std::string>& overrides,
                     std::vector<Diagnostic>* warnings, const Limits& limits,
                     std::vector<std::string>* other_files, std::vector<DeclaredParameter>* parameters);

}  // namespace mimbre::model_file
