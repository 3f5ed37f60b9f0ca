#include "common/bus/notes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "common/bus/clock_messages.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/bus/wire_format.hpp"
#include "common/test/bit_flips.hpp"
#include "common/types/bounded_time.hpp"

namespace roadbalance {
namespace {

using test::expect_every_bit_flip_refused;

TEST(Notes, RefuseEverySingleBitFlip) {
  expect_every_bit_flip_refused(
      encode(Journal{.node = 3, .epoch = 9, .first_sequence = 4, .last_sequence = 8}), decode_journal);
  expect_every_bit_flip_refused(encode(Note{.kind = NoteKind::kDiskFull, .text = "no space"}), decode_note);
  expect_every_bit_flip_refused(encode(Commit{.bytes = 123}), decode_commit);
  expect_every_bit_flip_refused(encode(ClockExchange{.node = 1, .number = 5}), decode_clock_exchange);
  expect_every_bit_flip_refused(encode(ClockFit{.node = 1, .number = 5, .drift = 1e-5}), decode_clock_fit);
  expect_every_bit_flip_refused(encode(RecorderStatus{.segment = 4}), decode_recorder_status);
}

TEST(Notes, ANoteArrivesAsItWasWrittenAndIsCutToItsLength) {
  const Note note{.time_us = 1,
                  .host_ns = 2,
                  .incarnation = 3,
                  .kind = NoteKind::kFallback,
                  .a = 4,
                  .b = -5,
                  .text = std::string(kMaxNoteBytes + 9, 'x')};
  const auto back = decode_note(encode(note));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->time_us, 1);
  EXPECT_EQ(back->host_ns, 2);
  EXPECT_EQ(back->incarnation, 3);
  EXPECT_EQ(back->kind, NoteKind::kFallback);
  EXPECT_EQ(back->a, 4);
  EXPECT_EQ(back->b, -5);
  EXPECT_EQ(back->text, std::string(kMaxNoteBytes, 'x'));
}

/// A record's own, whose text goes to terminals, into JSON and to other programs.
TEST(Notes, ATextIsShownPlain) {
  const Note note{.kind = NoteKind::kMark, .text = "abridge"};
  auto bytes = encode(note);
  const auto text = std::ranges::search(bytes, note.text).begin() - bytes.begin();
  for (const auto& [byte, shown] : {std::pair{0x1B, " bridge"}, {0xFF, "?bridge"}}) {
    bytes.at(static_cast<std::size_t>(text)) = static_cast<std::uint8_t>(byte);
    wire_format::write_crc(bytes);
    const auto back = decode_note(bytes);
    ASSERT_TRUE(back) << byte;
    EXPECT_EQ(back->text, shown);
  }
}

TEST(Notes, KnowKindsUpToTheLastAndRefuseOthers) {
  const auto is_known = [](int kind) {
    return decode_note(encode(Note{.kind = static_cast<NoteKind>(kind), .text = ""})).has_value();
  };
  EXPECT_TRUE(is_known(static_cast<int>(NoteKind::kStarted)));
  EXPECT_TRUE(is_known(static_cast<int>(NoteKind::kLast)));
  for (const int kind : {-1, 0, static_cast<int>(NoteKind::kLast) + 1}) EXPECT_FALSE(is_known(kind)) << kind;
}

TEST(Notes, SpeakOfSegmentsThatThereCanBe) {
  const auto is_told = [](NoteKind kind, std::int64_t segment, std::int64_t bytes) {
    return decode_note(encode(Note{.kind = kind, .a = segment, .b = bytes, .text = ""})).has_value();
  };
  for (const auto kind : {NoteKind::kSegmentAbandoned, NoteKind::kSegmentDeleted}) {
    EXPECT_TRUE(is_told(kind, 1, 0));
    EXPECT_TRUE(is_told(kind, std::numeric_limits<int>::max(), 0));
    for (const std::int64_t none : {std::int64_t{-5}, std::int64_t{0}, std::int64_t{1} << 40})
      EXPECT_FALSE(is_told(kind, none, 0)) << none;
    EXPECT_FALSE(is_told(kind, 1, -1));
  }
}

TEST(Notes, TellInstantsThatCanBeCountedFromOneAnotherOnly) {
  const auto is_told = [](std::int64_t time_us, std::int64_t host_ns) {
    return decode_note(encode(Note{.time_us = time_us, .host_ns = host_ns, .text = ""})).has_value();
  };
  for (const std::int64_t sign : {-1, 1}) {
    EXPECT_TRUE(is_told(sign * kUtcLimit_us, sign * kClockLimit_ns));
    EXPECT_FALSE(is_told(sign * (kUtcLimit_us + 1), 0));
    EXPECT_FALSE(is_told(0, sign * (kClockLimit_ns + 1)));
  }
  EXPECT_FALSE(is_told(0, std::numeric_limits<std::int64_t>::min()));
}

TEST(RecorderStatus, TellsThatTheSupplyIsGoneApartFromThatItCannotBeRead) {
  for (const bool gone : {false, true})
    for (const bool unknown : {false, true}) {
      const auto back =
          decode_recorder_status(encode(RecorderStatus{.on_battery = gone, .power_unknown = unknown}));
      ASSERT_TRUE(back);
      EXPECT_EQ(back->on_battery, gone);
      EXPECT_EQ(back->power_unknown, unknown);
    }
}

TEST(Notes, AJournalEntryArrivesAsItWasWritten) {
  Journal journal{.node = 7,
                  .epoch = -8,
                  .time_us = 9,
                  .first_sequence = 10,
                  .last_sequence = 12,
                  .first_scan = 13,
                  .next_scan = 99,
                  .scans = 80,
                  .scans_missing = 6,
                  .node_losses = {.repaired = 1,
                                  .spool_failures = 5,
                                  .scans_refused = 6,
                                  .blocks_unsent = 7,
                                  .acks_refused = 8,
                                  .encoder_faults = {9, 10},
                                  .unreferenced_blocks = 11},
                  .refused = 2,
                  .rivals = 3,
                  .unsent = 12,
                  .disk_failures = 4};
  journal.channel_crc[15] = 0xFFFFFFFFu;
  journal.node_losses.device_counts[kDeviceCounters - 1] = 13;
  const auto back = decode_journal(encode(journal));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->epoch, -8);
  EXPECT_EQ(back->last_sequence, 12);
  EXPECT_EQ(back->next_scan, 99);
  EXPECT_EQ(back->channel_crc, journal.channel_crc);
  EXPECT_EQ(back->node_losses, journal.node_losses);
  EXPECT_EQ(back->refused, 2);
  EXPECT_EQ(back->rivals, 3);
  EXPECT_EQ(back->unsent, 12);
  EXPECT_EQ(back->disk_failures, 4);
}

TEST(Notes, ACommitArrivesAsItWasWritten) {
  const auto back = decode_commit(encode(Commit{.bytes = std::int64_t{1} << 40}));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->bytes, std::int64_t{1} << 40);
}

TEST(Notes, ClockMessagesArriveAsTheyWereSent) {
  const ClockExchange exchange{.node = 2,
                               .epoch = -3,
                               .number = 4,
                               .asked_ns = 5,
                               .received_ns = 6,
                               .answered_ns = 7,
                               .heard_ns = 8,
                               .kernel_stamps = 10};
  EXPECT_EQ(decode_clock_exchange(encode(exchange)), exchange);
  const ClockFit fit{.node = 2,
                     .epoch = -3,
                     .number = 4,
                     .state = ClockState::kHoldover,
                     .host_ns = 5,
                     .node_ns = -6,
                     .drift = -3e-5,
                     .uncertainty_s = 1e-5,
                     .round_trip_s = 2e-5,
                     .residual_s = 3e-6,
                     .exchanges = 7,
                     .unanswered = 8,
                     .breaks = 1};
  EXPECT_EQ(decode_clock_fit(encode(fit)), fit);
}

}  // namespace
}  // namespace roadbalance
