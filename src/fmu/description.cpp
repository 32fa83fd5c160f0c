#include "fmu/description.h"

#include <fmt/format.h>

#include <charconv>
#include <cstring>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include "mimbre/diagnostics.h"

namespace mimbre::fmu {
namespace {

constexpr std::uint64_t most_elements = 1000000;

[[noreturn]] void refuse(const std::string& file, const std::string& why) {
  throw InputError({file, 0, 0}, why);
}

pugi::xml_document parsed(const std::string& xml, const std::string& name, const std::string& file) {
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(xml.data(), xml.size());
  if (!result)
    refuse(file, fmt::format("{} is no XML: {} (at byte {})", name, result.description(), result.offset));
  return document;
}

const std::map<std::string, Type>& types(int version) {
  static const std::map<std::string, Type> two{{"Real", Type::float64},
                                               {"Integer", Type::int32},
                                               {"Enumeration", Type::int32},
                                               {"Boolean", Type::boolean},
                                               {"String", Type::string}};
  static const std::map<std::string, Type> three{
      {"Float64", Type::float64},   {"Float32", Type::float32}, {"Int8", Type::int8},
      {"UInt8", Type::uint8},       {"Int16", Type::int16},     {"UInt16", Type::uint16},
      {"Int32", Type::int32},       {"UInt32", Type::uint32},   {"Int64", Type::int64},
      {"UInt64", Type::uint64},     {"Boolean", Type::boolean}, {"String", Type::string},
      {"Enumeration", Type::int64}, {"Binary", Type::other},    {"Clock", Type::other}};
  return version == 3 ? three : two;
}

/// A whole number as XML has it; false where it is none.
template <class T>
bool number_of(const char* text, T& value) {
  const char* const end = text + std::strlen(text);
  const auto result = std::from_chars(text, end, value);
  return result.ec == std::errc() && result.ptr == end;
}

bool flag(const pugi::xml_node& node, const char* name) {
  const std::string text = node.attribute(name).as_string();
  return text == "true" || text == "1";
}

class DescriptionReader {
 public:
  DescriptionReader(const std::string& xml, const std::string& file)
      : file_(file), document_(parsed(xml, "modelDescription.xml", file)) {}

  Description read() {
    const pugi::xml_node root = document_.child("fmiModelDescription");
    if (!root) refuse(file_, "modelDescription.xml has no element fmiModelDescription");
    const std::string version = root.attribute("fmiVersion").as_string();
    if (version.rfind("2.", 0) != 0 && version.rfind("3.", 0) != 0)
      refuse(file_, fmt::format("is of FMI '{}'; 2.0 and 3.0 are read", version));
    d_.version = version[0] == '3' ? 3 : 2;
    d_.model_name = root.attribute("modelName").as_string();
    d_.token = root.attribute(d_.version == 3 ? "instantiationToken" : "guid").as_string();
    const pugi::xml_node cs = root.child("CoSimulation");
    if (!cs)
      refuse(file_, fmt::format("has no co-simulation{}: export it once more with it",
                                root.child("ModelExchange") ? ", only model exchange" : ""));
    d_.identifier = cs.attribute("modelIdentifier").as_string();
    if (d_.identifier.empty() || d_.identifier.find_first_of("/\\") != std::string::npos ||
        d_.identifier.find("..") != std::string::npos)
      refuse(file_, fmt::format("its modelIdentifier '{}' is no name of a file", d_.identifier));
    const bool three = d_.version == 3;
    d_.once_per_process = flag(cs, "canBeInstantiatedOnlyOncePerProcess");
    d_.needs_tool = flag(cs, "needsExecutionTool");
    d_.saves_state = flag(cs, three ? "canGetAndSetFMUState" : "canGetAndSetFMUstate") &&
                     flag(cs, three ? "canSerializeFMUState" : "canSerializeFMUstate");
    for (const pugi::xml_node source : cs.child("SourceFiles").children("File"))
      d_.sources.emplace_back(source.attribute("name").as_string());
    read_variables(root.child("ModelVariables"));
    return std::move(d_);
  }

 private:
  void read_variables(const pugi::xml_node& list) {
    for (const pugi::xml_node node : list.children()) {
      if (node.type() != pugi::node_element) continue;
      if (d_.version == 2) {
        if (std::strcmp(node.name(), "ScalarVariable") == 0) read_scalar(node);
      } else {
        read_typed(node);
      }
    }
    std::set<std::string> names;
    for (const Variable& v : d_.variables)
      if (!names.insert(v.name).second) refuse(file_, fmt::format("has two variables '{}'", v.name));
    resolve_dimensions();
  }

  Variable head(const pugi::xml_node& node) {
    Variable v;
    v.name = node.attribute("name").as_string();
    if (v.name.empty()) refuse(file_, "has a variable without a name");
    if (!number_of(node.attribute("valueReference").as_string(), v.reference))
      refuse(file_, fmt::format("the valueReference '{}' of variable '{}' is no whole number",
                                node.attribute("valueReference").as_string(), v.name));
    v.causality = node.attribute("causality").as_string("local");
    v.variability = node.attribute("variability").as_string();
    v.initial = node.attribute("initial").as_string();
    return v;
  }

  void read_scalar(const pugi::xml_node& node) {
    Variable v = head(node);
    for (const pugi::xml_node child : node.children()) {
      const auto found = types(2).find(child.name());
      if (found == types(2).end()) continue;
      v.type = found->second;
      v.type_name = child.name();
      if (const auto start = child.attribute("start")) v.start = {{start.as_string()}};
      break;
    }
    if (v.type == Type::other) refuse(file_, fmt::format("variable '{}' has no type of FMI 2", v.name));
    d_.variables.push_back(std::move(v));
  }

  void read_typed(const pugi::xml_node& node) {
    const auto found = types(3).find(node.name());
    if (found == types(3).end()) return;
    Variable v = head(node);
    v.type = found->second;
    v.type_name = node.name();
    std::vector<std::optional<std::uint32_t>> by;
    for (const pugi::xml_node dimension : node.children("Dimension")) {
      std::uint64_t size = 0;
      std::uint32_t reference = 0;
      if (const auto start = dimension.attribute("start"); start && number_of(start.as_string(), size))
        by.emplace_back();
      else if (number_of(dimension.attribute("valueReference").as_string(), reference))
        by.emplace_back(reference);
      else
        refuse(file_, fmt::format("a dimension of variable '{}' has no size", v.name));
      v.dimensions.push_back(size);
    }
    dimensions_by_.push_back(by);
    if (v.type == Type::string || v.type == Type::other) {
      for (const pugi::xml_node start : node.children("Start")) {
        if (!v.start) v.start.emplace();
        v.start->emplace_back(start.attribute("value").as_string());
      }
    } else if (const auto start = node.attribute("start")) {
      std::istringstream words(start.as_string());
      v.start.emplace();
      for (std::string word; words >> word;) v.start->push_back(word);
    }
    d_.variables.push_back(std::move(v));
  }

  /// Sizes that a structural parameter decides.
  void resolve_dimensions() {
    if (d_.version != 3) return;
    for (std::size_t k = 0; k < d_.variables.size(); ++k) {
      Variable& v = d_.variables[k];
      for (std::size_t i = 0; i < v.dimensions.size(); ++i) {
        if (const auto& reference = dimensions_by_[k][i]) v.dimensions[i] = size_by(*reference, v.name);
        if (v.dimensions[i] > most_elements)
          refuse(file_, fmt::format("variable '{}' has a dimension of {}; up to {} elements are possible",
                                    v.name, v.dimensions[i], most_elements));
      }
      std::uint64_t size = 1;
      for (const std::uint64_t dimension : v.dimensions) {
        size *= dimension;
        if (size > most_elements)
          refuse(file_, fmt::format("variable '{}' has more than {} elements", v.name, most_elements));
      }
    }
  }

  std::uint64_t size_by(std::uint32_t reference, const std::string& of) {
    for (const Variable& v : d_.variables) {
      std::uint64_t size = 0;
      if (v.reference == reference && v.causality == "structuralParameter" && v.start &&
          v.start->size() == 1 && number_of(v.start->front().c_str(), size))
        return size;
    }
    refuse(file_,
           fmt::format("a dimension of variable '{}' is that of valueReference {}, which is no structural "
                       "parameter with a start value",
                       of, reference));
  }

  const std::string& file_;
  pugi::xml_document document_;
  Description d_;
  std::vector<std::vector<std::optional<std::uint32_t>>> dimensions_by_;
};

}  // namespace

std::uint64_t Variable::size() const {
  std::uint64_t n = 1;
  for (const std::uint64_t dimension : dimensions) n *= dimension;
  return n;
}

const Variable* Description::find(const std::string& name) const {
  for (const Variable& v : variables)
    if (v.name == name) return &v;
  return nullptr;
}

std::vector<std::string> Description::names(const std::string& causality) const {
  std::vector<std::string> all;
  for (const Variable& v : variables)
    if (v.causality == causality) all.push_back(v.name);
  return all;
}

Description read_description(const std::string& xml, const std::string& file) {
  return DescriptionReader(xml, file).read();
}

Sources read_build_description(const std::string& xml, const std::string& identifier,
                               const std::string& file) {
  const pugi::xml_document document = parsed(xml, "sources/buildDescription.xml", file);
  for (const pugi::xml_node build : document.child("fmiBuildDescription").children("BuildConfiguration")) {
    if (identifier != build.attribute("modelIdentifier").as_string()) continue;
    Sources sources;
    for (const pugi::xml_node set : build.children("SourceFileSet")) {
      const std::string language = set.attribute("language").as_string("C");
      if (language.rfind('C', 0) != 0)
        refuse(file, fmt::format("its sources are of language '{}'; C is compiled", language));
      for (const pugi::xml_node source : set.children("SourceFile"))
        sources.files.emplace_back(source.attribute("name").as_string());
      for (const pugi::xml_node word : set.children("PreprocessorDefinition")) {
        const std::string value = word.attribute("value").as_string();
        sources.definitions.push_back(word.attribute("name").as_string() +
                                      (value.empty() ? "" : "=" + value));
      }
      for (const pugi::xml_node folder : set.children("IncludeDirectory"))
        sources.include_folders.emplace_back(folder.attribute("name").as_string());
    }
    for (const pugi::xml_node library : build.children("Library"))
      if (!flag(library, "internal")) sources.libraries.emplace_back(library.attribute("name").as_string());
    return sources;
  }
  refuse(file, fmt::format("sources/buildDescription.xml has no configuration for '{}'", identifier));
}

}  // namespace mimbre::fmu
