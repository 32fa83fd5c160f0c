#pragma once
#include <string>
#include <vector>

namespace mimbre::test {

/// What of a JSON text breaks a JSON schema, each with its place; empty where it is valid. Knows the keywords
/// type, const, enum, properties, required, additionalProperties, items, minItems, minimum, oneOf and $ref
/// into $defs, and fails at any other that constrains.
std::vector<std::string> schema_violations(const std::string& text, const std::string& schema);

}  // namespace mimbre::test
