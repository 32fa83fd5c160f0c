#pragma once
#include <string_view>

namespace mimbre::live {

/// The solver of `mimbre page` as WebAssembly: base64 of a gzip file; empty where `make page` had not built
/// it. Defined in a file that the build generates (cmake/EmbedReport.cmake).
std::string_view page_solver();

}  // namespace mimbre::live
