#include "common/bus/absence.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

constexpr std::int64_t kNoon_us = 1'769'860'800'000'000;  // 2026-01-31 12:00:00 UTC, as date(1) says

TEST(Absence, SaysWhenAndWhy) {
  EXPECT_EQ(words({.node = 2, .cause = AbsenceCause::kNeverCame, .from_begin = true, .to_end = true}),
            "never came");
  EXPECT_EQ(words({.node = 2, .cause = AbsenceCause::kNeverCame, .seconds = 20.4, .from_begin = true}),
            "came 20 s late");
  EXPECT_EQ(words({.node = 2, .cause = AbsenceCause::kProgramEnded, .seconds = 38.2, .to_end = true}),
            "ended 38 s before the recording: its program was ended: by its service, a person or a closed "
            "terminal");
  EXPECT_EQ(words({.node = 2, .cause = AbsenceCause::kDeviceFailed, .seconds = 1200, .to_end = true}),
            "ended 20 min before the recording: its device failed: look at its cable and supply");
  EXPECT_EQ(words({.node = 2, .cause = AbsenceCause::kStopped, .seconds = 5.25}),
            "was away for 5.2 s: stopped by a command that was not this recorder's");
}

TEST(Absence, OfANodeThatIsNotHeardNamesTheInstant) {
  EXPECT_EQ(
      words({.node = 2, .cause = AbsenceCause::kSilent, .since_us = kNoon_us, .seconds = 38, .to_end = true}),
      "was not heard after 12:00:00 UTC, 38 s before the recording ended: look at its cable and supply");
  EXPECT_EQ(words({.node = 2, .cause = AbsenceCause::kSilent, .seconds = 42}),
            "was away for 42 s: its supply or its program failed");
}

TEST(Absence, NamesTheNodeIfItHasAName) {
  EXPECT_EQ(node_words(2, "rear"), "node 2 (rear)");
  EXPECT_EQ(node_words(2, ""), "node 2");
}

}  // namespace
}  // namespace roadbalance
