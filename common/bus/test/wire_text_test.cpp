#include "common/bus/wire_text.hpp"

#include <gtest/gtest.h>

#include <string>

namespace roadbalance::wire_text {
namespace {

TEST(WireText, TakesWhatPeopleWrite) {
  for (const char* text : {"", "drive 1", "Straße", "雪", "\xF0\x9F\x9A\x97",
                           "a\xC2\xA0"
                           "b"})
    EXPECT_TRUE(is_plain_text(text)) << text;
}

// The forms of The Unicode Standard 15.0, table 3-7, and what lies beside each.
TEST(WireText, RefusesWhatIsNoUtf8AndWhatControlsATerminal) {
  for (const char* text : {"\n", "a\x1b[2J", "\x7f",
                           "\xC2\x9B"
                           "2J",
                           "\x80", "\xC0\xAF", "\xC1\xBF", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xF0\x8F\xBF\xBF",
                           "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xE2\x82",
                           "\xC3"
                           "a"})
    EXPECT_FALSE(is_plain_text(text)) << text;
  EXPECT_FALSE(is_plain_text(std::string_view("a\0b", 3)));
}

TEST(WireText, WhateverIsSaidArrives) {
  EXPECT_EQ(plain_text("line 1\nline 2\tä"), "line 1 line 2 ä");
  EXPECT_EQ(plain_text("a\xFF\x80z"), "a??z");
  EXPECT_EQ(plain_text("\xE2\x82"), "??");
  std::string every;
  for (int byte = 0; byte < 256; ++byte) every += static_cast<char>(byte);
  EXPECT_TRUE(is_plain_text(plain_text(every)));
}

TEST(WireText, IsCutBetweenCharacters) {
  EXPECT_EQ(cut_to("abc", 3), "abc");
  EXPECT_EQ(cut_to("abc", 2), "ab");
  EXPECT_EQ(cut_to("ab\xC3\xA9", 3), "ab");
  EXPECT_EQ(cut_to("\xF0\x9F\x9A\x97", 3), "");
}

}  // namespace
}  // namespace roadbalance::wire_text
