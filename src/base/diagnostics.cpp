#include "mimbre/diagnostics.h"

#include <algorithm>
#include <cctype>
#include <numeric>
#include <utility>

namespace mimbre {

namespace {

std::string joined(const std::vector<Diagnostic>& diagnostics) {
  std::string text;
  for (const Diagnostic& diagnostic : diagnostics) {
    if (!text.empty()) text += '\n';
    text += to_string(diagnostic);
  }
  return text;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Edit distance in which a swap of neighbours counts as one edit (optimal string alignment).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  std::iota(above.begin(), above.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, above);
    std::swap(above, row);
  }
  return above[b.size()];
}

/// Longer names are not compared: hostile input must not make the quadratic distance slow.
constexpr std::size_t longest_compared_name = 100;

}  // namespace

std::string to_string(const Diagnostic& diagnostic) {
  const Mark& mark = diagnostic.mark;
  if (mark.line <= 0) return mark.file.empty() ? diagnostic.message : mark.file + ": " + diagnostic.message;
  return mark.file + ':' + std::to_string(mark.line) + ':' + std::to_string(mark.column) + ": " +
         diagnostic.message;
}

InputError::InputError(std::vector<Diagnostic> diagnostics)
    : std::runtime_error(joined(diagnostics)), diagnostics_(std::move(diagnostics)) {}

InputError::InputError(Mark mark, std::string message)
    : InputError(std::vector<Diagnostic>{{std::move(mark), std::move(message)}}) {}

std::string did_you_mean(const std::string& name, const std::vector<std::string>& candidates) {
  if (name.empty() || name.size() > longest_compared_name) return {};
  const std::string wanted = lower(name);
  const std::string* nearest = nullptr;
  // A third of the letters may differ; a short name still gets one edit.
  std::size_t limit = std::max<std::size_t>(1, name.size() / 3);
  for (const std::string& candidate : candidates) {
    if (candidate.empty() || candidate.size() > wanted.size() + limit) continue;
    const std::size_t distance = edit_distance(wanted, lower(candidate));
    // A replacement of the whole name is no likeness ("x" is not "y").
    if (distance > limit || distance >= std::max(name.size(), candidate.size())) continue;
    if (nearest && distance == limit) continue;
    nearest = &candidate;
    limit = distance;
  }
  return nearest ? " (did you mean '" + *nearest + "'?)" : std::string{};
}

}  // namespace mimbre
