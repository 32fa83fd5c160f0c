#include <cstddef>
#include <cstdint>

#include "mimbre/diagnostics.h"
#include "readers.h"

/// One reader under libFuzzer: MIMBRE_READER is its name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const mimbre::fuzz::Reader& reader = []() -> const mimbre::fuzz::Reader& {
    for (const mimbre::fuzz::Reader& one : mimbre::fuzz::readers())
      if (one.name == MIMBRE_READER) return one;
    __builtin_trap();
  }();
  try {
    reader.read(std::string(reinterpret_cast<const char*>(data), size));
  } catch (const mimbre::InputError&) {
  }
  return 0;
}
