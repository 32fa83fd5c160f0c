#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "fe_files/nastran/nastran_lines.h"

namespace mimbre::fe {

/// One bulk-data card with its continuations; fields without blanks, empty where there is nothing. Fields
/// count from the one behind the name, eight for each line of the card.
struct NastranCard {
  std::string name;  ///< capitals, without the star of the large field
  std::vector<std::string> fields;
  Mark mark;

  std::string_view field(std::size_t i) const { return i < fields.size() ? fields[i] : std::string_view(); }
  bool blank(std::size_t i) const { return field(i).empty(); }
  [[noreturn]] void fail(const std::string& message) const { throw InputError(mark, message); }

  /// A whole number, that must be there or is `missing` where the field is blank.
  std::int64_t whole(std::size_t i, const char* what) const;
  std::int64_t whole(std::size_t i, const char* what, std::int64_t missing) const;
  /// The number of a thing: whole and from 1.
  std::int64_t label(std::size_t i, const char* what) const;
  double real(std::size_t i, const char* what, double missing = 0) const;
  Eigen::Vector3d vector(std::size_t first, const char* what) const;
  /// Of components as 1246: a bit for each of 1 to 6. Blank and 0: none.
  unsigned components(std::size_t i) const;
};

std::string capitals(std::string_view text);

/// Cards of bulk data in small, large and free field, without comments, up to ENDDATA. Replication (=, ==,
/// *(1),
/// =(3)) makes cards of the one before.
class NastranCards {
 public:
  explicit NastranCards(NastranLines& lines) : lines_(lines) {}
  bool next(NastranCard& card);

 private:
  std::string increased(const std::string& value, std::string_view by) const;
  void replicate(NastranCard& card);

  NastranLines& lines_;
  NastranCard previous_;
  std::vector<std::string> pattern_;  ///< fields of the line that replicates
  std::int64_t repeat_ = 0;
};

}  // namespace mimbre::fe
