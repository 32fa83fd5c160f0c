#include "surfaces/check_ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

/// Stanford's polygon format: a header that lists what follows, how often and of which types, then the
/// numbers, as text or as bytes (G. Turk, The PLY polygon file format, 1994).
namespace mimbre {
namespace {

struct Property {
  std::string type, count;  ///< count: type of a list's length; empty: no list
};
struct Element {
  std::string name;
  double instances = 0;
  std::vector<Property> properties;
};
struct Header {
  std::string format;
  std::vector<Element> elements;
  std::size_t end = 0;  ///< where the numbers begin
  int lines = 0;
};

int size_of(const std::string& type) {
  static const std::map<std::string, int> sizes{{"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},
                                                {"short", 2}, {"ushort", 2},  {"int16", 2},  {"uint16", 2},
                                                {"int", 4},   {"uint", 4},    {"int32", 4},  {"uint32", 4},
                                                {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  const auto found = sizes.find(type);
  return found == sizes.end() ? 0 : found->second;
}

/// Nothing of a header that is not understood.
std::optional<Header> header_of(const std::string& text) {
  Header header;
  std::size_t at = 0;
  for (bool ended = false; !ended;) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string::npos) return {};
    std::istringstream line(text.substr(at, end - at));
    at = end + 1;
    ++header.lines;
    std::string word;
    line >> word;
    if (header.lines == 1) {
      if (word != "ply") return {};
    } else if (word == "format") {
      line >> header.format;
    } else if (word == "element") {
      Element element;
      line >> element.name >> element.instances;
      if (!line) return {};
      header.elements.push_back(std::move(element));
    } else if (word == "property" && !header.elements.empty()) {
      Property property;
      line >> property.type;
      if (property.type == "list") line >> property.count >> property.type;
      if (size_of(property.type) == 0 || (!property.count.empty() && size_of(property.count) == 0)) return {};
      header.elements.back().properties.push_back(std::move(property));
    } else if (word == "end_header") {
      ended = true;
    } else if (!word.empty() && word != "comment" && word != "obj_info") {
      return {};
    }
  }
  header.end = at;
  return header;
}

/// The numbers of a file of text. An instance begins in a line of its own.
class Text {
 public:
  Text(std::string_view text, int line) : text_(text), line_(line) {}

  void begin() {
    while (!first_ && at_ < text_.size() && text_[at_] != '\n') ++at_;
    first_ = false;
  }
  std::optional<double> next(std::string& fault) {
    while (at_ < text_.size() && is_space(text_[at_])) line_ += text_[at_++] == '\n';
    std::size_t end = at_;
    while (end < text_.size() && !is_space(text_[end])) ++end;
    std::string_view word = text_.substr(at_, end - at_);
    at_ = end;
    if (word.empty()) return {};
    if (word[0] == '+') word.remove_prefix(1);
    double number = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (stop == word.data() + word.size() && error != std::errc::invalid_argument) return number;
    fault = fmt::format("is damaged: '{}' in line {} is no number", word.substr(0, 40), line_);
    return {};
  }
  std::optional<double> next(const std::string&, std::string& fault) { return next(fault); }
  bool skip(double count, const std::string&, std::string& fault) {
    for (; count > 0; --count)
      if (!next(fault)) return false;
    return true;
  }

 private:
  static bool is_space(char c) {
    return c == ' ' || c == '\n' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
  }
  std::string_view text_;
  std::size_t at_ = 0;
  int line_;
  bool first_ = true;
};

/// Those of a file of bytes.
class Bytes {
 public:
  Bytes(std::string_view bytes, bool little) : bytes_(bytes), little_(little) {}

  void begin() {}
  std::optional<double> next(const std::string& type, std::string&) {
    const auto size = static_cast<std::size_t>(size_of(type));
    if (bytes_.size() - at_ < size) return {};
    std::string value(bytes_.substr(at_, size));
    at_ += size;
    if (little_ != (std::endian::native == std::endian::little)) std::reverse(value.begin(), value.end());
    if (type.starts_with("f") || type.starts_with("d"))
      return size == 4 ? static_cast<double>(as<float>(value)) : as<double>(value);
    const bool no_sign = type.starts_with("u");
    if (size == 1) return no_sign ? as<std::uint8_t>(value) : as<std::int8_t>(value);
    if (size == 2) return no_sign ? as<std::uint16_t>(value) : as<std::int16_t>(value);
    return no_sign ? as<std::uint32_t>(value) : as<std::int32_t>(value);
  }
  bool skip(double count, const std::string& type, std::string&) {
    const double size = count * size_of(type);
    if (size > static_cast<double>(bytes_.size() - at_)) return false;
    at_ += static_cast<std::size_t>(size);
    return true;
  }

 private:
  template <class Number>
  static Number as(const std::string& bytes) {
    Number number;
    std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool little_;
};

template <class Numbers>
std::string fault_in(const Header& header, Numbers numbers) {
  for (const Element& element : header.elements) {
    if (element.properties.empty()) continue;
    for (double k = 0; k < element.instances; ++k) {
      numbers.begin();
      std::string fault;
      const auto ends = [&] {
        return !fault.empty() ? fault
                              : fmt::format(
                                    "is damaged: its header names {} times '{}', and the file ends in the "
                                    "{}. of them",
                                    element.instances, element.name, k + 1);
      };
      for (const Property& property : element.properties) {
        double count = 1;
        if (!property.count.empty()) {
          const auto listed = numbers.next(property.count, fault);
          if (!listed) return ends();
          if (!(*listed >= 0))
            return fmt::format("is damaged: a list of '{}' has {} entries", element.name, *listed);
          count = *listed;
        }
        if (!numbers.skip(count, property.type, fault)) return ends();
      }
    }
  }
  return {};
}

}  // namespace

std::string why_not_ply(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (text.starts_with("ply") && text.find("end_header") == std::string::npos)
    return "is damaged: its header has no end, a line end_header";
  const auto header = header_of(text);
  if (!header) return {};
  const std::string_view numbers = std::string_view(text).substr(header->end);
  if (header->format == "ascii") return fault_in(*header, Text(numbers, header->lines + 1));
  if (header->format == "binary_little_endian") return fault_in(*header, Bytes(numbers, true));
  if (header->format == "binary_big_endian") return fault_in(*header, Bytes(numbers, false));
  return {};
}

}  // namespace mimbre
