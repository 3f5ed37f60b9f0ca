#include "host/web/request_relay.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

Request request(std::int64_t number) {
  return {.asker = 1, .request = number, .operation = Operation::kMark};
}

Answer answer(std::int64_t number, AnswerState state) {
  return {.asker = 1, .request = number, .operation = Operation::kMark, .state = state};
}

TEST(RequestRelay, RepeatsUntilTheLastWord) {
  RequestRelay relay;
  const WallTime now{};
  relay.take(request(5), now);
  relay.take(request(5), now);  // a repeated request counts once
  EXPECT_EQ(relay.due(now).size(), 1u);
  EXPECT_TRUE(relay.due(now + milliseconds(199)).empty());
  EXPECT_EQ(relay.due(now + RequestRelay::kRepeat), std::vector{request(5)});
  relay.take(answer(5, AnswerState::kUnderWay));
  EXPECT_EQ(relay.due(now + 2 * RequestRelay::kRepeat).size(), 1u);
  relay.take(answer(6, AnswerState::kDone));  // of another request
  EXPECT_EQ(relay.due(now + 3 * RequestRelay::kRepeat).size(), 1u);
  relay.take(answer(5, AnswerState::kRefused));
  EXPECT_TRUE(relay.due(now + 4 * RequestRelay::kRepeat).empty());
}

TEST(RequestRelay, GivesUpWhereNobodyAnswers) {
  RequestRelay relay;
  relay.take(request(5), WallTime{});
  EXPECT_EQ(relay.due(WallTime{} + RequestRelay::kPatience).size(), 1u);
  EXPECT_TRUE(relay.due(WallTime{} + RequestRelay::kPatience + milliseconds(1)).empty());
}

TEST(RequestRelay, HoldsAFew) {
  RequestRelay relay;
  for (std::int64_t number = 1; number <= 1000; ++number) relay.take(request(number), WallTime{});
  const auto due = relay.due(WallTime{});
  ASSERT_EQ(due.size(), RequestRelay::kMost);
  EXPECT_EQ(due.back(), request(1000));
}

}  // namespace
}  // namespace roadbalance
