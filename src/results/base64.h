#pragma once
#include <string>
#include <vector>

namespace mimbre::results {

/// RFC 4648, with padding.
std::string base64(const std::vector<unsigned char>& bytes);

}  // namespace mimbre::results
