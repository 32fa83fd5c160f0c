#include "app/json.h"

#include <nlohmann/json.hpp>

namespace mimbre::app {

std::string to_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace mimbre::app
