#pragma once
#include <string>
#include <vector>

#include "fe_files/text_file.h"

/// The form of tyre property files: sections in brackets, KEY = VALUE, comments behind $ and !.
namespace mimbre::tyre_files {

struct Property {
  std::string section, key;  ///< upper case
  std::string value;         ///< without quotes and comment
  bool text = false;         ///< was written in quotes
  Mark mark;
};

/// All of a file's properties in their order. Tables, rows of numbers below a line in braces, are skipped;
/// such rows elsewhere are mistakes: the value of a key that went to the next line, for instance.
/// Throws InputError at lines that are nothing of this.
std::vector<Property> read_properties(fe::TextFile& file);

}  // namespace mimbre::tyre_files
