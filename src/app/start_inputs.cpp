#include "app/start_inputs.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "mimbre/usage_error.h"

namespace mimbre::app {

double number_of(const std::string& text, const std::string& what) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw UsageError(what);
  return value;
}

void add_start_inputs_option(Parser& parser, std::vector<std::string>& given) {
  parser.add_option("--input", given, "Start value of an input or tunable parameter; several times")
      .repeated()
      .type_name("NAME=VALUE");
}

std::map<std::string, double> start_inputs(const std::vector<std::string>& given) {
  std::map<std::string, double> values;
  for (const std::string& text : given) {
    const auto place = text.find('=');
    if (place == std::string::npos || place == 0)
      throw UsageError(fmt::format("--input {}: NAME=VALUE is needed", text));
    const std::string name = text.substr(0, place);
    const double value =
        number_of(text.substr(place + 1), fmt::format("--input {}: the value is no finite number", text));
    if (!values.emplace(name, value).second)
      throw UsageError(fmt::format("--input {}: '{}' has a value already", text, name));
  }
  return values;
}

}  // namespace mimbre::app
