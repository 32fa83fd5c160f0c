#pragma once
#include <fmt/format.h>

#include <pugixml.hpp>
#include <string>

/// Writing XML.
namespace mimbre::portable {

pugi::xml_node begin_xml(pugi::xml_document& document, const char* root);
std::string text_of(const pugi::xml_document& document);

inline void set(pugi::xml_node node, const char* name, const std::string& value) {
  node.append_attribute(name).set_value(value.c_str());
}
inline void set(pugi::xml_node node, const char* name, const char* value) {
  node.append_attribute(name).set_value(value);
}
inline void set(pugi::xml_node node, const char* name, double value) {
  set(node, name, fmt::format("{}", value));
}

/// A text as one line.
std::string one_line(std::string text);

}  // namespace mimbre::portable
