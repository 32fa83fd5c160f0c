#include "support/json_schema.h"

#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

namespace mimbre::test {
namespace {

using nlohmann::json;

bool is_type(const json& value, const std::string& type) {
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "null") return value.is_null();
  if (type == "array") return value.is_array();
  if (type == "object") return value.is_object();
  throw std::runtime_error("the schema has the unknown type " + type);
}

class Validator {
 public:
  explicit Validator(const json& root) : root_(root) {}

  std::vector<std::string> violations(const json& value, const json& schema, const std::string& place) const {
    std::vector<std::string> found;
    const auto wrong = [&](const std::string& what) { found.push_back(place + ": " + what); };
    const auto look_into = [&](const json& inner, const json& by, const std::string& where) {
      for (std::string& one : violations(inner, by, where)) found.push_back(std::move(one));
    };
    if (schema.is_boolean()) {
      if (!schema.get<bool>()) wrong("is not foreseen");
      return found;
    }
    static const std::set<std::string> known{
        "type",  "const",    "enum",    "properties", "required", "additionalProperties",
        "items", "minItems", "minimum", "oneOf",      "$ref",     "description",
        "title", "$schema",  "$defs"};
    for (const auto& [keyword, by] : schema.items())
      if (!known.contains(keyword)) throw std::runtime_error("the schema has the unknown keyword " + keyword);
    if (schema.contains("$ref")) {
      const std::string name = schema["$ref"], before = "#/$defs/";
      look_into(value, root_.at("$defs").at(name.substr(before.size())), place);
    }
    if (schema.contains("oneOf")) {
      int fitting = 0;
      std::vector<std::string> nearest;  // of the choices, what is wrong by the one that it is meant to be
      for (const json& choice : schema["oneOf"]) {
        auto these = violations(value, choice, place);
        fitting += these.empty();
        if (nearest.empty() || these.size() < nearest.size()) nearest = std::move(these);
      }
      const std::string why = nearest.empty() ? "" : nearest.front();
      if (fitting != 1) wrong(std::to_string(fitting) + " choices fit; " + why);
    }
    if (schema.contains("const") && value != schema["const"])
      wrong("is not the constant " + schema["const"].dump());
    if (schema.contains("enum")) {
      const auto& list = schema["enum"];
      if (std::find(list.begin(), list.end(), value) == list.end())
        wrong(value.dump() + " is none of " + list.dump());
    }
    if (schema.contains("type")) {
      const json& type = schema["type"];
      bool fits = false;
      for (const json& one : type.is_array() ? type : json::array({type})) fits = fits || is_type(value, one);
      if (!fits) {
        wrong(value.dump() + " is no " + type.dump());
        return found;
      }
    }
    if (schema.contains("minimum") && value.is_number() && value < schema["minimum"])
      wrong(value.dump() + " is too small");
    if (value.is_array()) {
      if (schema.contains("minItems") && value.size() < schema["minItems"]) wrong("has too few items");
      if (schema.contains("items"))
        for (std::size_t k = 0; k < value.size(); ++k)
          look_into(value[k], schema["items"], place + "[" + std::to_string(k) + "]");
    }
    if (!value.is_object()) return found;
    const json properties = schema.value("properties", json::object());
    for (const json& key : schema.value("required", json::array()))
      if (!value.contains(key.get<std::string>())) wrong("has no " + key.dump());
    for (const auto& [key, inner] : value.items()) {
      if (properties.contains(key))
        look_into(inner, properties[key], place + "." + key);
      else if (schema.contains("additionalProperties"))
        look_into(inner, schema["additionalProperties"], place + "." + key);
    }
    return found;
  }

 private:
  const json& root_;
};

}  // namespace

std::vector<std::string> schema_violations(const std::string& text, const std::string& schema) {
  const json root = json::parse(schema);
  return Validator(root).violations(json::parse(text), root, "$");
}

}  // namespace mimbre::test
