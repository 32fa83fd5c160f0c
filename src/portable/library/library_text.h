#pragma once

/// Parts of the C99 around the library's runtime, with '@' for the model's name.
namespace mimbre::portable {

extern const char* const library_header_text;
extern const char* const library_source_text;

}  // namespace mimbre::portable
