#pragma once
#include <fmt/format.h>

#include <initializer_list>
#include <string>

#include "portable/code_parts.h"
#include "portable/program.h"

namespace mimbre::portable {

/// Writes constants of a source, "#define PREFIX_WORD value".
class Constants {
 public:
  Constants(std::string& to, std::string prefix) : to_(to), prefix_(std::move(prefix)) {}

  void text(const char* word, const std::string& value) const {
    to_ += fmt::format("#define {}_{} {}\n", prefix_, word, value);
  }
  void operator()(const char* word, long value) const { text(word, fmt::format("{}", value)); }
  void operator()(const char* word, double value) const { text(word, literal(value)); }

  /// Those that the header of `name` has, in capitals; the same words where the name is in capitals itself.
  void of_header(const std::string& name, std::initializer_list<const char*> words) const {
    const std::string upper = upper_case(name);
    for (const char* word : words)
      if (prefix_ != upper) text(word, upper + "_" + word);
  }

 private:
  std::string& to_;
  const std::string prefix_;
};

}  // namespace mimbre::portable
