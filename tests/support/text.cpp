#include "support/text.h"

#include <regex>

namespace mimbre::test {

std::vector<std::vector<std::string>> matches(const std::string& text, const std::string& pattern,
                                              bool ignore_case) {
  const std::regex regex(pattern,
                         ignore_case ? std::regex::ECMAScript | std::regex::icase : std::regex::ECMAScript);
  std::vector<std::vector<std::string>> all;
  for (std::sregex_iterator it(text.begin(), text.end(), regex); it != std::sregex_iterator(); ++it) {
    std::vector<std::string>& groups = all.emplace_back();
    for (const auto& group : *it) groups.push_back(group.str());
  }
  return all;
}

std::string replaced(const std::string& text, const std::string& pattern, const std::string& by) {
  return std::regex_replace(text, std::regex(pattern), by);
}

}  // namespace mimbre::test
