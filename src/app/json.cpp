#include "app/json.h"

#include <nlohmann/json.hpp>

#include "mimbre/text.h"

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
  return printable_json(json.dump(indent, ' ', false, Json::error_handler_t::replace));
}

}  // namespace mimbre::app
