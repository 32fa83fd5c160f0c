#pragma once
#include <string_view>

namespace mimbre::live {

/// The page of the live server, bundled from web/, complete as it is; empty when it was not built in.
/// Defined in a file that the build generates (cmake/EmbedReport.cmake).
std::string_view live_page();
/// The same of `mimbre page`, in which %MIMBRE_DATA% stands for the data.
std::string_view model_page();

}  // namespace mimbre::live
