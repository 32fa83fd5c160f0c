#pragma once
#include <string>
#include <vector>

#include "fe_files/text_file.h"

namespace mimbre::fe {

/// One bulk-data card with its continuations; fields without blanks, empty where there is nothing.
struct NastranCard {
  std::string name;  ///< capitals, without the star of the large field
  std::vector<std::string> fields;
  Mark mark;

  std::string_view field(std::size_t i) const { return i < fields.size() ? fields[i] : std::string_view(); }
};

/// Cards of a bulk-data or punch file in small, large and free field, without comments.
class NastranCards {
 public:
  explicit NastranCards(TextFile& file) : file_(file) {}
  bool next(NastranCard& card);

 private:
  TextFile& file_;
};

}  // namespace mimbre::fe
