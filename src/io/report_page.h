#pragma once
#include <string_view>

namespace mimbre::io {

/// The bundled page of web/, with `%MIMBRE_DATA%` where the data go; empty when it was not built in.
/// Defined in a file that the build generates (cmake/EmbedReport.cmake).
std::string_view report_page();

}  // namespace mimbre::io
