// Losses without a gap that declares them.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record_writer.hpp"
#include "common/record/segment_index.hpp"
#include "host/recording/verify/test/written_record.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {
namespace {

using test::kEpoch;

class VerifyLosses : public test::WrittenRecord {};

// An epoch that lies wholly in deleted segments leaves no gap, and the note on the first segment went with
// the second.
TEST_F(VerifyLosses, ARecordWithoutTheSegmentsThatRetentionDeletedIsIncompleteThoughEachEpochHereIsWhole) {
  put_scans(0);
  put_end(20);
  writer->close();
  writer.emplace(RecordWriter::Options{.folder = folder});
  writer->append(kNoteChannel, encode(Note{.kind = NoteKind::kSegmentDeleted, .a = 1, .text = {}}), 0);
  writer->close();
  writer.emplace(RecordWriter::Options{.folder = folder});
  writer->append(kNoteChannel, encode(Note{.kind = NoteKind::kSegmentDeleted, .a = 2, .text = {}}), 0);
  SealedBlock end;
  seal(EndBlock{.header = {.node = 2, .epoch = 7, .sequence = 1}, .blocks = 1}, end);
  writer->append(end, 0);
  writer->close();
  ASSERT_EQ(verify_record(folder).verdict, Verdict::kComplete) << "all of it is still here";
  delete_segment(folder, 1);
  delete_segment(folder, 2);
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kIncomplete);
  EXPECT_EQ(verdict_text(v), "incomplete, what is lost is listed");
  EXPECT_EQ(v.lost, std::vector<std::string>{"segments 1 to 2 were deleted by the retention mode"});
}

TEST_F(VerifyLosses, WhatTheJournalSaysOfAnEpochWithoutAnyBlockIsDamage) {
  put_scans(0);
  put_end(20);
  const Journal entry{.node = 2, .epoch = 7, .first_sequence = 1, .last_sequence = 652};
  writer->append(kJournalChannel, encode(entry), 0);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  ASSERT_EQ(v.epoch.size(), 2u);
  EXPECT_EQ(v.epoch[1].node, 2);
  ASSERT_EQ(v.epoch[1].contradictions.size(), 1u);
  EXPECT_NE(v.epoch[1].contradictions[0].find("blocks 1 to 652: here are no blocks"), std::string::npos);
}

TEST_F(VerifyLosses, TheEndTellsHowManyScansALossOfUnknownLengthHad) {
  put_scans(0);
  sequence += 2;
  put_gap(20, 0, GapCause::kLostAtNode);
  put_scans(100);
  put_end(120);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kIncomplete) << verdict_text(v);
  EXPECT_EQ(v.epoch.at(0).samples_missing, 80);
  EXPECT_TRUE(v.epoch[0].contradictions.empty()) << v.epoch[0].contradictions[0];
}

TEST_F(VerifyLosses, NamesAnAlteredEntryOfTheClocks) {
  auto fit = encode(ClockFit{.node = 1, .epoch = kEpoch});
  fit[30] ^= 4;
  put_scans(0);
  writer->append(clock_fit_channel(1), fit, 0);
  writer->append("OTHER_PROGRAM", fit, 0);  // of another program
  put_end(20);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  EXPECT_EQ(v.entries_refused, 1);
  EXPECT_EQ(v.other_events, 1);
  ASSERT_EQ(v.damage.size(), 1u);
  EXPECT_NE(v.damage[0].find("an altered entry"), std::string::npos) << v.damage[0];
}

// As an attacker leaves it, or a program with a bug: only the commit behind it shows.
TEST_F(VerifyLosses, NamesAnEntryThatWasAlteredWithItsCrc) {
  const std::string good = [] {
    const auto bytes = encode(ClockFit{.node = 1, .epoch = kEpoch, .host_ns = 1'000});
    return std::string(bytes.begin(), bytes.end());
  }();
  const auto other = encode(ClockFit{.node = 1, .epoch = kEpoch, .host_ns = 2'000});
  put_scans(0);
  writer->append(clock_fit_channel(1),
                 std::span(reinterpret_cast<const std::uint8_t*>(good.data()), good.size()), 0);
  put_end(20);
  EXPECT_EQ(result().verdict, Verdict::kComplete);
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    std::stringstream bytes;
    bytes << std::ifstream(file.path(), std::ios::binary).rdbuf();
    std::string log = bytes.str();
    const std::size_t at = log.find(good);
    if (at == std::string::npos) continue;
    log.replace(at, good.size(), std::string(other.begin(), other.end()));
    std::ofstream(file.path(), std::ios::binary) << log;
  }
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  EXPECT_EQ(v.entries_refused, 0);
  EXPECT_EQ(v.altered_headers, 1);
}

// Marked ten seconds after a 1970 clock began, 20 s before it was set to 2026-11-30T08:00:30.
TEST_F(VerifyLosses, NotesBearTheTimeOfTheClockThatWasSetBehindThem) {
  constexpr std::int64_t kSecond_us = 1'000'000, kNow_us = 1'796'025'630 * kSecond_us;
  const auto note = [this](NoteKind kind, std::int64_t time_us, std::int64_t a) {
    writer->append(kNoteChannel, encode(Note{.time_us = time_us, .kind = kind, .a = a, .text = {}}), 0);
  };
  put_scans(0);
  put_end(20);
  note(NoteKind::kMark, 10 * kSecond_us, 1);
  note(NoteKind::kClockSet, kNow_us, kNow_us - 30 * kSecond_us);
  const Verification v = result();
  ASSERT_EQ(v.notes.size(), 2u);
  EXPECT_TRUE(v.notes[0].starts_with("2026-11-30T08:00:10Z ")) << v.notes[0];
  EXPECT_TRUE(v.notes[1].starts_with("2026-11-30T08:00:30Z ")) << v.notes[1];
}

TEST_F(VerifyLosses, ARecorderThatStoppedWithMoreThanIsHereTellsOfALoss) {
  const auto note = [this](NoteKind kind, std::int64_t a, std::int64_t b) {
    writer->append(kNoteChannel, encode(Note{.kind = kind, .a = a, .b = b, .text = {}}), 0);
  };
  put_scans(0);
  put_end(20);
  note(NoteKind::kStopped, 0, 0);  // without any loss
  note(NoteKind::kMark, 3, 0);
  note(NoteKind::kStopped, 1, 3);
  EXPECT_EQ(result().verdict, Verdict::kComplete);
  writer.emplace(RecordWriter::Options{.folder = folder});
  note(NoteKind::kStopped, 2, 4);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kIncomplete);
  EXPECT_EQ(v.lost,
            (std::vector<std::string>{"the recorder stopped with 2 node epochs; here are 1",
                                      "the recorder stopped with mark 4 set; the last one here is 3"}));
}

}  // namespace
}  // namespace roadbalance
