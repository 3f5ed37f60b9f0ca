#include "host/recording/verify/verify_presence.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using Words = std::vector<std::string>;

class PresenceCheckTest : public ::testing::Test {
 protected:
  void note(int second, NoteKind kind, std::int64_t node = 0, std::int64_t b = 0, std::string text = "") {
    check.take({.time_us = 1'000'000LL * second, .kind = kind, .a = node, .b = b, .text = std::move(text)});
  }
  void missing(int second, AbsenceCause cause) {
    note(second, NoteKind::kNodeMissing, 2, static_cast<std::int64_t>(cause), "rear");
  }
  Words absences(const std::set<std::int32_t>& ended = {}) const {
    Words all;
    for (const Absence& absence : check.absences(ended)) all.push_back(words(absence));
    return all;
  }
  PresenceCheck check;
};

TEST_F(PresenceCheckTest, WhoEndedIsMissedUpToTheStop) {
  note(100, NoteKind::kStarted, 1);
  missing(150, AbsenceCause::kDeviceFailed);
  note(188, NoteKind::kStopping);
  note(195, NoteKind::kStopped);
  EXPECT_EQ(absences({2}),
            (Words{"ended 38 s before the recording: its device failed: look at its cable and supply"}));
  EXPECT_EQ(check.sentence(check.absences({2}).front()),
            "node 2 (rear) ended 38 s before the recording: its device failed: look at its cable and supply");
}

// 1970 -> 2026, as of a board without a battery that is given the time.
TEST_F(PresenceCheckTest, ASetClockMovesWhatWasBefore) {
  note(100, NoteKind::kStarted, 1);
  missing(150, AbsenceCause::kDeviceFailed);
  constexpr int kSet = 1'700'000'000;
  check.take({.time_us = 1'000'000LL * (kSet + 160),
              .kind = NoteKind::kClockSet,
              .a = 1'000'000LL * kSet,
              .text = {}});
  note(kSet + 188, NoteKind::kStopping);
  EXPECT_EQ(absences({2}),
            (Words{"ended 38 s before the recording: its device failed: look at its cable and supply"}));
  EXPECT_EQ(check.absences({2}).front().since_us, 1'000'000LL * (kSet + 150));
}

TEST_F(PresenceCheckTest, WithoutAStopItIsMissedUpToTheLastEvent) {
  missing(150, AbsenceCause::kDeviceFailed);
  check.take_time(160'000'000);
  EXPECT_EQ(absences(),
            (Words{"ended 10 s before the recording: its device failed: look at its cable and supply"}));
}

TEST_F(PresenceCheckTest, AbsenceFromTheBegin) {
  missing(100, AbsenceCause::kNeverCame);
  note(120, NoteKind::kNodeThere, 2, 1);
  note(130, NoteKind::kStopping);
  EXPECT_EQ(absences(), (Words{"came 20 s late"}));
}

TEST_F(PresenceCheckTest, WhoWasOnlyNotHeardLacksNothing) {
  missing(100, AbsenceCause::kSilent);
  note(110, NoteKind::kNodeThere, 2, 0);
  note(130, NoteKind::kStopping);
  EXPECT_EQ(absences(), Words());
}

TEST_F(PresenceCheckTest, WhoWasNotHeardInTheEndAndToldItsEndSinceLacksNothing) {
  missing(100, AbsenceCause::kSilent);
  note(130, NoteKind::kStopping);
  EXPECT_EQ(absences({2}), Words());
  EXPECT_EQ(absences().size(), 1u) << "it has not";
}

TEST_F(PresenceCheckTest, WhatHappenedReplacesThatItWasNotHeard) {
  missing(100, AbsenceCause::kSilent);
  missing(110, AbsenceCause::kDeviceFailed);
  note(130, NoteKind::kStopping);
  EXPECT_EQ(absences({2}),
            (Words{"ended 30 s before the recording: its device failed: look at its cable and supply"}));
}

TEST_F(PresenceCheckTest, ARecorderThatIsStartedAgainMissesTheSameNode) {
  missing(100, AbsenceCause::kDeviceFailed);
  note(110, NoteKind::kStarted, 2);
  missing(110, AbsenceCause::kNeverCame);
  note(140, NoteKind::kStopping);
  EXPECT_EQ(absences(),
            (Words{"ended 40 s before the recording: its device failed: look at its cable and supply"}));
}

}  // namespace
}  // namespace roadbalance
