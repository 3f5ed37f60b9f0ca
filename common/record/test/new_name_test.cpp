#include "common/record/new_name.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

// Microsoft, Naming Files, Paths, and Namespaces.
TEST(NewName, IsNoneThatWindowsRefuses) {
  for (const char* refused :
       {"con",       "CON",    "Aux.txt", "prn", "nul.tar.gz", "com1", "COM0", "LPT9.old",
        "lpt\u00B2", "con .x", "CONIN$",  "x.",  "x ",         "a<b",  "a>b",  "a:b",
        "a\"b",      "a/b",    "a\\b",    "a|b", "a?b",        "a*b",  ""})
    EXPECT_NE(fault_of_folder_name(refused), "") << refused;
  for (const char* free : {"contact", "com", "com10", "comet", "console", "x.y", ".x", "gr\u00F6\u00DFer",
                           "my con", "2024-05-01T12-00-00", "a'b", "a b"})
    EXPECT_EQ(fault_of_folder_name(free), "") << free;
}

TEST(NewName, HasNoHiddenCharacter) {
  for (const char* refused : {"a\x1b"
                              "b",
                              "a\nb", "a\tb", "drive\u202E",
                              "a\u200B"
                              "b",
                              "a\uFE0F", "a\U000E0041"})
    EXPECT_NE(fault_of_folder_name(refused).find("this one has \\"), std::string::npos) << refused;
}

TEST(NewName, CapitalsAloneMakeNoOther) {
  const test::TemporaryDirectory all;
  std::filesystem::create_directory(all.path() / "Drive 1");
  for (const char* other : {"drive 1", "DRIVE 1", "drive 1/"}) {
    EXPECT_EQ(differs_by_capitals(all.path() / other), "Drive 1");
    EXPECT_THROW(expect_new_name(all.path() / other), std::invalid_argument) << other;
  }
  for (const char* free : {"Drive 1", "drive 2", "drive 1.part"})
    EXPECT_NO_THROW(expect_new_name(all.path() / free));
  EXPECT_EQ(differs_by_capitals(all.path() / "not made yet" / "drive 1"), "");
}

}  // namespace
}  // namespace roadbalance
