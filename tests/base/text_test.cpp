#include "mimbre/text.h"

#include <gtest/gtest.h>

/// What a terminal may show.
namespace mimbre::text_test {
namespace {

TEST(Text, Utf8IsToldFromOtherBytes) {
  for (const char* good : {"", "arm", "Länge", "µm ³ → 長さ", "😀", "\x7f\x01"})
    EXPECT_EQ(first_not_utf8(good), std::string::npos) << good;
  EXPECT_EQ(first_not_utf8("L\xE4nge"), 1u);          // Latin-1
  EXPECT_EQ(first_not_utf8("ab\xC3"), 2u);            // cut off
  EXPECT_EQ(first_not_utf8("\xC0\xAF"), 0u);          // longer than need be
  EXPECT_EQ(first_not_utf8("a\xED\xA0\x80"), 1u);     // half of UTF-16
  EXPECT_EQ(first_not_utf8("\xF4\x90\x80\x80"), 0u);  // beyond U+10FFFF
  EXPECT_EQ(first_not_utf8("\x80"), 0u);
}

TEST(Text, ControlCharactersAreShownNotObeyed) {
  EXPECT_EQ(printable("plain Länge\n\tline"), "plain Länge\n\tline");
  EXPECT_EQ(printable("\x1b[31mred"), "\\x1b[31mred");
  EXPECT_EQ(printable("a\x07"
                      "b\rc\x7f"),
            "a\\x07b\\x0dc\\x7f");
  EXPECT_EQ(printable("\xC2\x9B"
                      "31m"),
            "\\x9b31m");  // the CSI of eight bits
  EXPECT_EQ(printable("L\xE4nge"), "L\xEF\xBF\xBDnge");
  EXPECT_EQ(first_not_utf8(printable("\xFF\xFE\xC2")), std::string::npos);
}

}  // namespace
}  // namespace mimbre::text_test
