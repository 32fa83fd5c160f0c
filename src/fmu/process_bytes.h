#pragma once
#include <span>

namespace mimbre::fmu {

/// The program of src/fmu/process, which the build compiles in (cmake/EmbedFmuProcess.cmake).
std::span<const unsigned char> process_bytes();

}  // namespace mimbre::fmu
