#pragma once
#include <string>
#include <vector>

/// Regular expressions on texts (ECMAScript's), which take long to compile.
namespace mimbre::test {

/// The whole match and its groups, of every match.
std::vector<std::vector<std::string>> matches(const std::string& text, const std::string& pattern,
                                              bool ignore_case = false);
/// Every match replaced.
std::string replaced(const std::string& text, const std::string& pattern, const std::string& by);

}  // namespace mimbre::test
