#include "host/recording/subset/subset_notes.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

// Whichever instants are wanted: the time of the loss is unknown.
TEST(SubsetNotes, ALossOfTheOriginalIsALossOfEachSubset) {
  const Note lost{.kind = NoteKind::kDiskFailed, .text = "495 bytes that are no events"};
  EXPECT_EQ(use_of(lost), NoteUse::kAlways);
  EXPECT_EQ(use_of({.kind = NoteKind::kDiskFailed, .a = 5, .b = 2, .text = {}}), NoteUse::kIfWanted);
}

}  // namespace
}  // namespace roadbalance
