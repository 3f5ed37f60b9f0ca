#include "common/text/markup.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(Markup, WhatIsGivenAMeaningIsEscapedAndTheRestIsAsItWas) {
  EXPECT_EQ(markup_text("a <b> & \"c\" 'd' 25\u00a0m/s\u00b2\n\t."),
            "a &lt;b&gt; &amp; &quot;c&quot; 'd' 25\u00a0m/s\u00b2\n\t.");
}

TEST(Markup, WhatIsEscapedIsNotTakenForAnEntity) {
  EXPECT_EQ(markup_text("&lt;"), "&amp;lt;");
}

TEST(Markup, HiddenCharactersAreShown) {
  EXPECT_EQ(markup_text(std::string_view("a\0b\x1b[1m\r", 8)), "a\\x00b\\x1B[1m\\x0D");
  EXPECT_EQ(markup_text("drive\u202Elmth.<"), "drive\\u202Elmth.&lt;");
}

}  // namespace
}  // namespace roadbalance
