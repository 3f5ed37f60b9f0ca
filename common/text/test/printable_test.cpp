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

TEST(PrintableText, IsOneLineWhateverItIsMadeOf) {
  EXPECT_EQ(printable_text("car\ncomplete"), "car\\x0Acomplete");
  EXPECT_EQ(printable_text("a\tb"), "a\\x09b");
  EXPECT_EQ(printable_text("a\xE2\x80\xA8\xE2\x80\xA9"), "a\\u2028\\u2029");
  EXPECT_EQ(first_hidden("car\ncomplete"), "\\x0A");
}

TEST(PrintableText, ShowsWhatTurnsOrHidesOtherText) {
  EXPECT_EQ(printable_text("front\xE2\x80\xAEtfel"), "front\\u202Etfel") << "right to left";
  EXPECT_EQ(printable_text("drive\xE2\x80\x8B 1"), "drive\\u200B 1") << "no width";
  EXPECT_EQ(printable_text("\xEF\xBB\xBF"), "\\uFEFF");
  EXPECT_EQ(printable_text("\xE2\x81\xA6\xD8\x9C\xC2\xAD"), "\\u2066\\u061C\\xAD");
  EXPECT_EQ(printable_text("a\u034F\uFE0Fb\uFE00"), "a\\u034F\\uFE0Fb\\uFE00")
      << "joiner and selectors of variants";
  EXPECT_EQ(printable_text("\U000E0041\U000E007F"), "\\U000E0041\\U000E007F") << "tags";
  EXPECT_EQ(printable_text("x\U000E0100\U000E01EF"), "x\\U000E0100\\U000E01EF") << "more selectors";
  EXPECT_EQ(printable_text("\u3164\uFFA0\u115F"), "\\u3164\\uFFA0\\u115F") << "fillers";
  EXPECT_EQ(first_hidden("bumpy road"), "");
  EXPECT_EQ(first_hidden("bump\xE2\x80\xAE\x1B"), "\\u202E");
  EXPECT_EQ(first_hidden("cut \xE2\x80"), "") << "half a character";
  EXPECT_EQ(first_hidden("cut \xF3\xA0\x81"), "") << "three quarters of one";
}

TEST(PrintableText, LeavesAllOthersAsTheyAre) {
  EXPECT_EQ(printable_text("\xE2\x80\x93\xE2\x80\xA6\xE2\x82\xAC \xF0\x9F\x9A\x97"),
            "\xE2\x80\x93\xE2\x80\xA6\xE2\x82\xAC \xF0\x9F\x9A\x97");
  EXPECT_EQ(printable_text("größer, 2 × 3 °C"), "größer, 2 × 3 °C");
  EXPECT_EQ(printable_text("\uFE10\uFDFF\U000DFFFF\U000F0000\U0010FFFF"),
            "\uFE10\uFDFF\U000DFFFF\U000F0000\U0010FFFF");
  EXPECT_EQ(printable_text("\xC2\xA0\xC2"), "\xC2\xA0\xC2");
  EXPECT_EQ(printable_text(""), "");
}

}  // namespace
}  // namespace roadbalance
