#include "results/superseded_parts.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <vector>

#include "base/output_place.h"

namespace mimbre::results {
namespace {

constexpr std::size_t chunk = std::size_t{1} << 20;

/// Whether the file begins with all that the part has.
bool begins_with(const std::string& file, const std::string& part) {
  std::ifstream whole(file, std::ios::binary), beginning(part, std::ios::binary);
  if (!whole || !beginning) return false;
  std::vector<char> a(chunk), b(chunk);
  while (beginning.read(b.data(), chunk) || beginning.gcount() > 0) {
    const auto count = beginning.gcount();
    whole.read(a.data(), count);
    if (whole.gcount() != count || !std::equal(a.begin(), a.begin() + count, b.begin())) return false;
  }
  return beginning.eof();
}

/// Whether the bytes stand somewhere in the file.
bool holds(const std::string& path, const std::string& bytes) {
  std::ifstream file(path, std::ios::binary);
  std::string seen;
  std::vector<char> next(chunk);
  while (file.read(next.data(), chunk) || file.gcount() > 0) {
    seen.append(next.data(), static_cast<std::size_t>(file.gcount()));
    if (seen.find(bytes) != std::string::npos) return true;
    if (seen.size() >= bytes.size()) seen.erase(0, seen.size() - bytes.size() + 1);
  }
  return false;
}

}  // namespace

void remove_superseded_tables(const std::string& target) noexcept {
  try {
    remove_abandoned_parts(
        target, [&](const std::string& part) { return !is_kept(part, target) && begins_with(target, part); });
  } catch (const std::exception&) {
  }
}

// The bytes are searched: a file that was killed while it was written may be damaged, and is not opened.
void remove_superseded_results(const std::string& target, const std::string& model_text,
                               const std::string& options_json) noexcept {
  try {
    if (model_text.empty()) return;
    remove_abandoned_parts(target, [&](const std::string& part) {
      return !is_kept(part, target) &&
             (std::filesystem::is_empty(part) || (holds(part, model_text) && holds(part, options_json)));
    });
  } catch (const std::exception&) {
  }
}

}  // namespace mimbre::results
