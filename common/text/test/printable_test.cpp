#include "common/text/printable.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(PrintableText, ShowsWhatWouldCommandATerminal) {
  EXPECT_EQ(printable_text("drive\x1b[31m\x07.lcm"), "drive\\x1B[31m\\x07.lcm");
  EXPECT_EQ(printable_text("a\rb\x7f"), "a\\x0Db\\x7F");
  EXPECT_EQ(printable_text("\xC2\x9B"
                           "2J"),
            "\\x9B2J")
      << "CSI as one character";
  EXPECT_EQ(printable_text(std::string_view("\0", 1)), "\\x00");
}

TEST(PrintableText, ShowsWhatTurnsOrHidesOtherText) {
  EXPECT_EQ(printable_text("front\xE2\x80\xAEtfel"), "front\\u202Etfel") << "right to left";
  EXPECT_EQ(printable_text("drive\xE2\x80\x8B 1"), "drive\\u200B 1") << "no width";
  EXPECT_EQ(printable_text("\xEF\xBB\xBF"), "\\uFEFF");
  EXPECT_EQ(printable_text("\xE2\x81\xA6\xD8\x9C\xC2\xAD"), "\\u2066\\u061C\\xAD");
  EXPECT_EQ(first_hidden("bumpy road"), "");
  EXPECT_EQ(first_hidden("bump\xE2\x80\xAE\x1B"), "\\u202E");
  EXPECT_EQ(first_hidden("cut \xE2\x80"), "") << "half a character";
}

TEST(PrintableText, LeavesAllOthersAsTheyAre) {
  EXPECT_EQ(printable_text("\xE2\x80\x93\xE2\x80\xA6\xE2\x82\xAC \xF0\x9F\x9A\x97"),
            "\xE2\x80\x93\xE2\x80\xA6\xE2\x82\xAC \xF0\x9F\x9A\x97");
  EXPECT_EQ(printable_text("größer, 2 × 3 °C\n\tnext"), "größer, 2 × 3 °C\n\tnext");
  EXPECT_EQ(printable_text("\xC2\xA0\xC2"), "\xC2\xA0\xC2");
  EXPECT_EQ(printable_text(""), "");
}

}  // namespace
}  // namespace roadbalance
