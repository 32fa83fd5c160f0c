#pragma once
#include <functional>
#include <string>
#include <vector>

/// The readers of all file formats, as functions of a file's bytes, for libFuzzer (libfuzzer.cpp) and for the
/// mutation of sample files (mutate.cpp).
namespace mimbre::fuzz {

struct Reader {
  std::string name;
  /// Any bytes either are read or are refused with an InputError. Everything else is a fault.
  std::function<void(const std::string& bytes)> read;
  /// Files that are good, for mutation. `sources` is the folder of the project.
  std::function<std::vector<std::string>(const std::string& sources)> samples;
};

const std::vector<Reader>& readers();

}  // namespace mimbre::fuzz
