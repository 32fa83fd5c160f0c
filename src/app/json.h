#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

/// A unit that makes or reads JSON includes <nlohmann/json.hpp> too; who only passes it on does not.
namespace mimbre::app {

/// Objects keep the order in which their keys were written.
using Json = nlohmann::ordered_json;

/// The beginning of what a command answers with --json (schema/output.schema.json).
Json answer(const std::string& command, const std::string& status = "ok");

/// What a command answers that has made one file or folder: its name, with `json` as JSON. A line.
std::string made(const std::string& command, const std::string& output, bool json);

/// JSON text; numbers that are not finite become null, text that is not UTF-8 is replaced, control
/// characters are escaped.
std::string to_text(const Json& json, int indent = 2);

}  // namespace mimbre::app
