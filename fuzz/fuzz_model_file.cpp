#include <cstddef>
#include <cstdint>
#include <string>

#include "mimbre/diagnostics.h"
#include "model_file/parse.h"

/// Any text either becomes a model or an InputError. Without a folder no file is read.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  mimbre::model_file::Limits limits;
  limits.bytes = 1u << 16;
  limits.nodes = 5000;
  limits.elements = 20;
  limits.dynamic_modes = 4;
  try {
    mimbre::model_file::parse(text, "fuzz.yaml", "", {}, nullptr, limits);
  } catch (const mimbre::InputError&) {
  }
  return 0;
}
