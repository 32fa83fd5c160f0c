#include "fe_files/matrix_files.h"
#include "fuzz_bytes.h"

#include <algorithm>

using namespace mimbre::fe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::vector<Dof> rows = {{0, 0}, {0, 1}, {1, 0}, {1, 1}};
  return read_text_or_refuse(data, size, [&](TextFile& file) {
    MatrixMarketHead head = parse_matrix_market_head(file);
    head.rows = std::min<std::int64_t>(head.rows, 4);
    Triangles triangles;
    parse_matrix_market_entries(file, head, rows, triangles);
  });
}
