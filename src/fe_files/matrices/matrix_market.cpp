#include <fmt/format.h>

#include <algorithm>

#include "fe_files/matrices/matrix_files.h"
#include "fe_files/text.h"

// Format: R. F. Boisvert, R. Pozo, K. A. Remington, The Matrix Market exchange formats, NISTIR 5935, 1996.

namespace mimbre::fe {

MatrixMarketHead parse_matrix_market_head(TextFile& file) {
  std::string_view line = file.expect("the head");
  const std::string head = lower(line);
  std::string_view rest = head;
  if (next_word(rest) != "%%matrixmarket" || next_word(rest) != "matrix")
    file.fail(
        "is no Matrix Market file: the first line must be '%%MatrixMarket matrix coordinate real symmetric'");
  if (const std::string_view format = next_word(rest); format != "coordinate")
    file.fail(fmt::format("format '{}' is not read; 'coordinate' is needed", shown(format)));
  if (const std::string_view field = next_word(rest);
      field != "real" && field != "integer" && field != "double")
    file.fail(fmt::format("field '{}' is not read; 'real' is needed", shown(field)));
  MatrixMarketHead result;
  const std::string_view symmetry = next_word(rest);
  result.symmetric = symmetry == "symmetric";
  if (!result.symmetric && symmetry != "general")
    file.fail(fmt::format("symmetry '{}' is not read; 'symmetric' or 'general' is needed", shown(symmetry)));
  do line = trimmed(file.expect("the head"));
  while (line.empty() || line.starts_with('%'));
  const auto rows = to_integer(next_word(line)), columns = to_integer(next_word(line)),
             entries = to_integer(next_word(line));
  if (!rows || !columns || !entries || *rows < 1 || *entries < 0 || !trimmed(line).empty())
    file.fail("the numbers of rows, columns and entries are needed");
  if (*rows != *columns)
    file.fail(fmt::format("has {} rows and {} columns; it must be square", *rows, *columns));
  result.rows = *rows;
  result.entries = *entries;
  return result;
}

SymmetricEntries parse_matrix_market_entries(TextFile& file, const MatrixMarketHead& head,
                                             const std::vector<Dof>& rows, Triangles& triangles) {
  SymmetricEntries entries;
  std::string_view line;
  std::int64_t count = 0;
  while (file.next(line)) {
    std::string_view rest = line;
    const std::string_view first = next_word(rest);
    if (first.empty() || first.starts_with('%')) continue;
    const auto row = to_integer(first), column = to_integer(next_word(rest));
    const auto value = to_real(next_word(rest));
    if (!row || !column || !value || !trimmed(rest).empty())
      file.fail(fmt::format("'{}' is no entry: row, column and a finite value are needed", shown(line)));
    if (*row < 1 || *column < 1 || *row > head.rows || *column > head.rows)
      file.fail(fmt::format("the entry ({}, {}) is outside of {} rows", *row, *column, head.rows));
    if (++count > head.entries)
      file.fail(fmt::format("has more than the {} entries that its head announces", head.entries));
    triangles.note(*row, *column);
    entries.add(dof_key(rows[static_cast<std::size_t>(*row - 1)]),
                dof_key(rows[static_cast<std::size_t>(*column - 1)]), *value);
  }
  if (count != head.entries) file.fail(fmt::format("ends after {} of {} entries", count, head.entries));
  return entries;
}

}  // namespace mimbre::fe
