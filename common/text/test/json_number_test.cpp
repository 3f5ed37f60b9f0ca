#include "common/text/json_number.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using Json = nlohmann::json;

TEST(JsonNumber, IsWhatTheFileSays) {
  EXPECT_EQ(whole_number(Json::parse("0")), 0);
  EXPECT_EQ(whole_number(Json::parse("9223372036854775807")), INT64_MAX);
  EXPECT_EQ(whole_number(Json::parse("-9223372036854775808")), INT64_MIN);
  EXPECT_EQ(whole_number(Json::parse("-3"), -3, 7), -3);
  EXPECT_EQ(whole_number(Json::parse("7"), -3, 7), 7);
  EXPECT_EQ(small_number(Json::parse("2147483647")), INT32_MAX);
}

TEST(JsonNumber, IsRefusedUnlessItIsWholeAndInItsRange) {
  const auto refusal = [](const char* text, std::int64_t least, std::int64_t most) -> std::string {
    try {
      whole_number(Json::parse(text), least, most);
      return "";
    } catch (const std::out_of_range& error) {
      return error.what();
    }
  };
  for (const char* none : {"4e52", "1.5", "1.0", "true", "null", "\"1\"", "[1]", "{}", "9223372036854775808"})
    EXPECT_NE(refusal(none, INT64_MIN, INT64_MAX).find("no whole number"), std::string::npos) << none;
  EXPECT_EQ(refusal("-4", -3, 7), "no whole number from -3 to 7");
  EXPECT_EQ(refusal("8", -3, 7), "no whole number from -3 to 7");
  EXPECT_THROW(small_number(Json::parse("-1")), std::out_of_range);
  EXPECT_THROW(small_number(Json::parse("2147483648")), std::out_of_range);
  EXPECT_THROW(small_number(Json::parse("5"), 0, 4), std::out_of_range);
}

}  // namespace
}  // namespace roadbalance
