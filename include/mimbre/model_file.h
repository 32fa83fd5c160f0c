#pragma once
#include <map>
#include <string>
#include <vector>

#include "mimbre/spec.h"

namespace mimbre {

/// Reads a YAML model file (format in docs/model-file.md, JSON schema in schema/model.schema.json).
/// `overrides` replace parameters of the file by name ("stairs" → "0.2").
/// Throws InputError with every mistake that was found. `warnings` (optional) receives what is suspicious,
/// `other_files` (optional) the paths of what was read with it: templates, reduced bodies.
spec::Model load_model(const std::string& path, const std::map<std::string, std::string>& overrides = {},
                       std::vector<Diagnostic>* warnings = nullptr,
                       std::vector<std::string>* other_files = nullptr);

/// The same from text; `name` stands for the file in messages, relative paths start at `directory`.
spec::Model parse_model(const std::string& text, const std::string& name, const std::string& directory,
                        const std::map<std::string, std::string>& overrides = {},
                        std::vector<Diagnostic>* warnings = nullptr,
                        std::vector<std::string>* other_files = nullptr);

}  // namespace mimbre
