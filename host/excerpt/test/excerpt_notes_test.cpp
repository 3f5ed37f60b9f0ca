#include "host/excerpt/excerpt_notes.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

// Whatever instants are wanted: nobody knows which ones it was lost from.
TEST(ExcerptNotes, WhatWasLostFromTheOriginalIsLostFromEachExcerpt) {
  const Note lost{.kind = NoteKind::kDiskFailed, .text = "495 bytes that are no events"};
  EXPECT_EQ(goes(lost), NoteGoes::kAlways);
  EXPECT_EQ(goes({.kind = NoteKind::kDiskFailed, .a = 5, .b = 2, .text = {}}), NoteGoes::kAlong);
}

}  // namespace
}  // namespace roadbalance
