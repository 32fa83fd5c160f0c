#pragma once
#include <memory>
#include <string>
#include <vector>

#include "mimbre/diagnostics.h"
#include "model_file/text/limits.h"

namespace mimbre::model_file {

/// A YAML value with its place. Scalars stay text: what they mean is decided by who reads them.
struct Tree {
  enum class Kind { null, scalar, list, map } kind = Kind::null;
  struct Entry {
    std::string key;
    Mark mark;
    std::shared_ptr<const Tree> value;
  };
  Mark mark;
  std::string text;                                ///< scalar
  std::vector<std::shared_ptr<const Tree>> items;  ///< list
  std::vector<Entry> entries;                      ///< map, in file order, keys unique
  std::size_t size = 1;                            ///< values in it, aliases expanded

  const Entry* find(const std::string& key) const {
    for (const Entry& entry : entries)
      if (entry.key == key) return &entry;
    return nullptr;
  }
};

/// Reads one YAML document. Appends duplicate keys to `errors`; throws InputError where the text cannot be
/// read at all (not YAML, empty, too large, too deep).
std::shared_ptr<const Tree> parse_yaml(const std::string& text, const std::string& file, const Limits& limits,
                                       std::vector<Diagnostic>& errors);

}  // namespace mimbre::model_file
