#pragma once
#include <string>

namespace mimbre {

/// Why a .ply file does not match its header, so that no reader is sent into it; empty: it does, or
/// its header is one that this does not know.
std::string why_not_ply(const std::string& path);

}  // namespace mimbre
