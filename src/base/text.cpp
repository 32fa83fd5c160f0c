#include "mimbre/text.h"

#include <algorithm>

namespace mimbre {

namespace {

unsigned byte(const std::string& text, std::size_t i) { return static_cast<unsigned char>(text[i]); }

/// Bytes of the character that begins at `i`: 1 to 4; 0 where none does.
std::size_t character_length(const std::string& text, std::size_t i) {
  const unsigned first = byte(text, i);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  if (length == 0 || i + length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k)
    if ((byte(text, i + k) & 0xC0) != 0x80) return 0;
  const unsigned second = byte(text, i + 1);
  // Longer than need be, halves of UTF-16, beyond U+10FFFF.
  const bool bad = (first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) ||
                   (first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F);
  return bad ? 0 : length;
}

}  // namespace

std::size_t first_not_utf8(const std::string& text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_length(text, i);
    if (length == 0) return i;
    i += length;
  }
  return std::string::npos;
}

std::string printable(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_length(text, i);
    const unsigned code = byte(text, i);
    // U+0080 to U+009F are control characters too, in two bytes.
    const bool high_control = length == 2 && code == 0xC2 && byte(text, i + 1) < 0xA0;
    if (length == 0) {
      result += "\xEF\xBF\xBD";
    } else if (high_control || code == 0x7F || (code < 0x20 && code != '\n' && code != '\t')) {
      constexpr char digits[] = "0123456789abcdef";
      const unsigned shown = high_control ? byte(text, i + 1) : code;
      result += {'\\', 'x', digits[shown >> 4], digits[shown & 15]};
    } else {
      result.append(text, i, length);
    }
    i += std::max<std::size_t>(length, 1);
  }
  return result;
}

std::string printable_json(const std::string& json) {
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  text.reserve(json.size());
  for (std::size_t i = 0; i < json.size(); ++i) {
    const bool two = byte(json, i) == 0xC2 && i + 1 < json.size() && byte(json, i + 1) < 0xA0;
    if (two) ++i;
    if (const unsigned control = byte(json, i); two || control == 0x7F)
      text += std::string("\\u00") + digits[control / 16] + digits[control % 16];
    else
      text += json[i];
  }
  return text;
}

}  // namespace mimbre
