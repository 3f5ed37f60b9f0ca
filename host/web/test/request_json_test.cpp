#include "host/web/request_json.hpp"

#include <gtest/gtest.h>

#include <string>

namespace roadbalance {
namespace {

std::string fault_of(std::string_view body) {
  const auto parsed = parse_request(body);
  const auto* fault = std::get_if<std::string>(&parsed);
  return fault ? *fault : "";
}

TEST(RequestJson, SaysWhatThePageSays) {
  const auto parsed = parse_request(
      R"({"asker": 7, "request": 8, "operation": "range", "node": 2, "channel": 4, "value": [50, 0.5], "text": "ä"})");
  ASSERT_TRUE(std::holds_alternative<Request>(parsed));
  const Request expected{.asker = 7,
                         .request = 8,
                         .operation = Operation::kRange,
                         .node = 2,
                         .channel = 4,
                         .value = {50, 0.5},
                         .text = "ä"};
  EXPECT_EQ(std::get<Request>(parsed), expected);
}

TEST(RequestJson, KnowsEveryOperationByItsName) {
  for (int k = 1; k <= 10; ++k) {
    const auto name = name_of(static_cast<Operation>(k));
    const auto parsed =
        parse_request(R"({"asker": 1, "request": 2, "operation": ")" + std::string(name) + "\"}");
    ASSERT_TRUE(std::holds_alternative<Request>(parsed)) << name;
    EXPECT_EQ(std::get<Request>(parsed).operation, static_cast<Operation>(k));
  }
}

TEST(RequestJson, RefusesWhatIsNoRequestAndSaysWhy) {
  EXPECT_EQ(fault_of(""), "no JSON object");
  EXPECT_EQ(fault_of("[]"), "no JSON object");
  EXPECT_EQ(fault_of("{"), "no JSON object");
  EXPECT_EQ(fault_of(R"({"asker": 1, "operation": "mark"})"), "request is missing");
  const auto with = [](const std::string& rest) {
    return fault_of(R"({"asker": 1, "request": 2, "operation": "mark")" + rest + "}");
  };
  EXPECT_EQ(with(""), "");
  EXPECT_EQ(with(R"(, "path": "/etc/passwd")"), "unknown key");
  EXPECT_EQ(with(R"(, "node": 1.5)"), "node is no whole number");
  EXPECT_EQ(with(R"(, "node": 10000)"), "node is out of bounds");
  EXPECT_EQ(with(R"(, "channel": 12)"), "a number cannot be");
  EXPECT_EQ(with(R"(, "value": [1, 2, 3])"), "value is no array of one or two numbers");
  EXPECT_EQ(with(R"(, "value": ["a"])"), "value is no array of one or two numbers");
  EXPECT_EQ(with(R"(, "text": "\u001b[2J")"), "text has control characters");
  EXPECT_EQ(with(R"(, "text": "\u009b2J")"), "text has control characters");  // the same in one character
  EXPECT_EQ(with(R"(, "text": ")" + std::string(401, 'x') + "\""), "text is no text of at most 400 bytes");
  EXPECT_EQ(with(R"(, "text": [[[[[]]]]])"), "too deep");
  EXPECT_EQ(fault_of(R"({"asker": 9007199254740992, "request": 2, "operation": "mark"})"),
            "asker is too large");
  EXPECT_EQ(fault_of(R"({"asker": -1, "request": 2, "operation": "mark"})"), "a number cannot be");
  EXPECT_EQ(
      fault_of(R"({"asker": 1, "request": 2, "operation": "delete"})"),
      "operation is none of start, stop, mark, range, filter, zero, vehicle, job, cancel, scale, reading, "
      "datum");
}

}  // namespace
}  // namespace roadbalance
