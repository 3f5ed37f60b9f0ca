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

TEST(PrintableText, LeavesAllOthersAsTheyAre) {
  EXPECT_EQ(printable_text("größer, 2 × 3 °C\n\tnext"), "größer, 2 × 3 °C\n\tnext");
  EXPECT_EQ(printable_text("\xC2\xA0\xC2"), "\xC2\xA0\xC2");
  EXPECT_EQ(printable_text(""), "");
}

}  // namespace
}  // namespace roadbalance
