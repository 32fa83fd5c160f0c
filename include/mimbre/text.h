#pragma once
#include <cstddef>
#include <string>

/// Text from outside, before anybody is shown it.
namespace mimbre {

/// Where the first byte is that is no UTF-8 (RFC 3629); std::string::npos where all is.
std::size_t first_not_utf8(const std::string& text);

/// The text as a terminal may show it: control characters but line breaks and tabs as \x1b, what is no UTF-8
/// as U+FFFD. Names and paths from outside go through it, since an escape sequence could display anything.
std::string printable(const std::string& text);

/// JSON text as a terminal may show it: control characters that JSON lets stand, DEL and U+0080 to U+009F,
/// are escaped.
std::string printable_json(const std::string& json);

}  // namespace mimbre
