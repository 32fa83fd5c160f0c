#include "app/json.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace mimbre::app {

Json answer(const std::string& command, const std::string& status) {
  return {{"command", command}, {"status", status}};
}

std::string made(const std::string& command, const std::string& output, bool json) {
  if (!json) return output + '\n';
  Json object = answer(command);
  object["output"] = output;
  return to_text(object) + '\n';
}

std::string to_text(const Json& json, int indent) {
  const std::string dumped = json.dump(indent, ' ', false, Json::error_handler_t::replace);
  // JSON lets these control characters stand, a terminal obeys them: DEL, and U+0080 to U+009F in two bytes.
  std::string text;
  text.reserve(dumped.size());
  for (std::size_t i = 0; i < dumped.size(); ++i) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(dumped[k]); };
    if (byte(i) == 0x7F)
      text += "\\u007f";
    else if (byte(i) == 0xC2 && byte(i + 1) < 0xA0)
      text += fmt::format("\\u{:04x}", byte(++i));
    else
      text += dumped[i];
  }
  return text;
}

}  // namespace mimbre::app
