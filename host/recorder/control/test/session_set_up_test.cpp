#include "host/recorder/control/test/session_fixture.hpp"

namespace roadbalance {
namespace {

using test::ask;
using test::kNow;
using test::SessionControllerTest;

class SessionSetUpTest : public SessionControllerTest {
 protected:
  // Asked, put under way and done.
  void do_set_up(SessionController& controller, std::int64_t number, double value) {
    Request request = ask(Operation::kRange, number);
    request.value = {value, 0};
    controller.take(request, kNow, {1});
    ASSERT_EQ(last(controller).state, AnswerState::kUnderWay);
    controller.was_set_up({.asker = 7,
                           .request = number,
                           .operation = Operation::kRange,
                           .state = AnswerState::kDone,
                           .text = "a range of " + std::to_string(value)});
  }
};

// Whoever has not heard the answer to the first repeats it, and must not undo what another asked since.
TEST_F(SessionSetUpTest, IsNotDoneAgainByARecorderThatComesAfterAnotherOne) {
  {
    SessionController first = controller();
    do_set_up(first, 1, 20);
    first.take(ask(Operation::kFilter, 2), kNow, {1});
  }
  SessionController second = controller();  // the first was killed
  set_up = {};
  second.take(ask(Operation::kRange, 1), kNow, {1});
  const Answer answer = last(second);
  EXPECT_EQ(answer.state, AnswerState::kDone);
  EXPECT_EQ(answer.value[0], 20);
  EXPECT_EQ(answer.text, "a range of 20.000000");
  EXPECT_EQ(set_up.request, 0) << "it was put under way again";
  second.take(ask(Operation::kFilter, 2), kNow, {1});
  EXPECT_EQ(last(second).state, AnswerState::kUnderWay) << "the one of which nothing is known yet";
}

TEST_F(SessionSetUpTest, TheBookRemembersTheLatest) {
  SessionController controller = this->controller();
  for (std::int64_t number = 1; number <= 100; ++number) do_set_up(controller, number, 1);
  ASSERT_EQ(state.set_up_before.size(), kMostSetUps);
  EXPECT_EQ(state.set_up_before.back().asked.request, 99);
  EXPECT_EQ(state.set_up->asked.request, 100);
}

}  // namespace
}  // namespace roadbalance
