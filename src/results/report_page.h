#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace mimbre::results {

/// The bundled page of web/, with `%MIMBRE_DATA%` where the data go; empty when it was not built in.
/// Defined in a file that the build generates (cmake/EmbedReport.cmake).
std::string_view report_page();

/// The page with its data. Throws std::runtime_error when it was not built in.
std::string page_with(const nlohmann::ordered_json& data);

/// Writes next to `path` first, then renames. Throws std::runtime_error when the file cannot be written.
void write_page(const std::string& html, const std::string& path);

}  // namespace mimbre::results
