#include "tools/datum/datum_dialogue.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

WheelConfig wheel(const std::string& name) {
  WheelConfig w{};
  w.name = name;
  w.encoder.pulses_per_turn = 96;
  return w;
}

/// A person before the screen; time passes when the test lets it.
class Dialogue : public testing::Test {
 protected:
  std::string edge(EdgeKind kind) {
    now_ += milliseconds(20);
    return dialogue_.take({node_time_from_ns(now_.time_since_epoch().count()), 0, kind}, now_);
  }
  /// A turn, which ends `teeth` behind the mark.
  std::string turn(int teeth = 3) {
    for (int k = 0; k < 40; ++k) EXPECT_EQ(edge(EdgeKind::kTooth), "");
    const std::string said = edge(EdgeKind::kZeroMark);
    for (int k = 0; k < teeth; ++k) EXPECT_EQ(edge(EdgeKind::kTooth), "");
    return said;
  }
  std::string stand() {
    now_ += DatumDialogue::kStill;
    return dialogue_.tick(now_);
  }
  std::string answer(const std::string& line) { return dialogue_.answer(line, now_); }

  DatumDialogue dialogue_{wheel("front_left"), 3};
  WallTime now_{};
};

TEST_F(Dialogue, AsksAtTheMarkAndTakesTheAnswerWhenTheWheelHasBeenStill) {
  EXPECT_NE(dialogue_.greeting().find("seen from outside against the clock"), std::string::npos);
  EXPECT_NE(DatumDialogue(wheel("rear_right"), 3).greeting().find("outside with the clock"),
            std::string::npos);
  for (int n = 0; n < 3; ++n) {
    EXPECT_FALSE(dialogue_.awaits_answer(now_));
    EXPECT_NE(turn(n).find("zero mark"), std::string::npos);
    EXPECT_FALSE(dialogue_.awaits_answer(now_)) << "it still turns";
    EXPECT_EQ(stand(), "");
    EXPECT_TRUE(dialogue_.awaits_answer(now_));
    EXPECT_EQ(answer("10:30"), "");
    EXPECT_FALSE(dialogue_.done());
    EXPECT_EQ(stand().find("45.0 deg (10:30): datum "), 0U);
  }
  EXPECT_TRUE(dialogue_.done());
  EXPECT_EQ(dialogue_.objection(), "");
  // 0, 1 and 2 teeth of 3.75 degrees behind the mark, which lies midway between two.
  const double mean = 45.0 - (0.25 + 1.0 + 2.0) / 3.0 * 3.75;
  EXPECT_NEAR(dialogue_.readings().datum()->datum_rad * 180.0 / std::numbers::pi, mean, 0.7);
}

TEST_F(Dialogue, TakesNoAnswerWhileTheWheelTurnsOrBeforeItsMark) {
  EXPECT_NE(answer("45").find("has not fired"), std::string::npos);
  turn();
  EXPECT_EQ(answer("45"), "");
  EXPECT_NE(edge(EdgeKind::kTooth).find("still turns"), std::string::npos);
  EXPECT_EQ(stand(), "");
  EXPECT_EQ(dialogue_.readings().readings(), 0U);
  EXPECT_NE(answer("half past ten").find("no place on a wheel"), std::string::npos);
  EXPECT_NE(edge(EdgeKind::kLost).find("lost"), std::string::npos);
  EXPECT_NE(answer("45").find("has not fired"), std::string::npos);
}

TEST_F(Dialogue, ObjectsToReadingsThatDoNotAgreeAndTakesOneBack) {
  for (const char* said : {"45", "46", "80"}) {
    turn();
    EXPECT_EQ(answer(said), "");
    stand();
  }
  EXPECT_TRUE(dialogue_.done());
  EXPECT_NE(dialogue_.objection().find("do not agree"), std::string::npos);
  EXPECT_NE(answer("undo").find("3 of 3"), std::string::npos);
  EXPECT_FALSE(dialogue_.done());
  EXPECT_EQ(dialogue_.objection(), "");
}

}  // namespace
}  // namespace roadbalance
