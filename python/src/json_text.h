#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "mimbre/text.h"

namespace mimbre::python {

/// Objects keep the order in which their keys were written.
using Json = nlohmann::ordered_json;

/// As the program writes it.
inline std::string json_text(const Json& json) {
  return printable_json(json.dump(2, ' ', false, Json::error_handler_t::replace));
}

}  // namespace mimbre::python
