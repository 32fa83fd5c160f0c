#include "fuzz_bytes.h"
#include "io/fe/matrix_files.h"

using namespace mimbre::fe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return read_or_refuse(data, size, [](std::string bytes) { parse_npz(std::move(bytes), "fuzz"); });
}
