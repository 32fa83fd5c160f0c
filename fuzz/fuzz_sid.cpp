#include "fe_files/reduced_files.h"
#include "fuzz_bytes.h"

using namespace mimbre::fe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return read_text_or_refuse(data, size, [](TextFile& file) { parse_sid(file); });
}
