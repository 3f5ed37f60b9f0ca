#include "host/recordings/recording_summary.hpp"

#include "common/bus/clock_messages.hpp"
#include "common/bus/notes.hpp"
#include "host/recording/verify/test/written_record.hpp"

namespace roadbalance {
namespace {

class SummaryOfARecording : public test::WrittenRecord {
 protected:
  /// 20 scans of 0.5 ms.
  void put_overloaded(std::int64_t first_scan, std::uint32_t overload) {
    ScanBlock block;
    block.header = header(first_scan, 20);
    block.period_ps = 500'000'000;
    block.overload = overload;
    put(block);
  }
  RecordingSummary summary() {
    writer->close();
    return summary_of(folder);
  }
};

TEST_F(SummaryOfARecording, HasWhatWasRecordedAndLost) {
  put_overloaded(0, 0);
  put_overloaded(20, 1U << 3);
  put_gap(40, 100, GapCause::kRingFull);
  put_overloaded(140, 1U << 3 | 1U << 5);
  put_end(60, 100);
  const RecordingSummary found = summary();
  EXPECT_EQ(found.name, folder.filename().string());
  EXPECT_EQ(found.state, RecordingState::kIncomplete);
  ASSERT_EQ(found.node.size(), 1U);
  EXPECT_EQ(found.node[0].node, 1);
  EXPECT_EQ(found.node[0].samples, 60);
  EXPECT_EQ(found.node[0].samples_lost, 100);
  EXPECT_NEAR(found.node[0].seconds, 60 * 0.5e-3, 1e-12);
  EXPECT_NEAR(found.node[0].overload_s, 2 * 20 * 0.5e-3, 1e-12) << "two blocks, however many channels";
  EXPECT_EQ(found.node[0].sync_residual_s, -1.0) << "no clock was asked";
  EXPECT_EQ(found.refused, 0);
  EXPECT_GT(found.bytes, 3 * 1300);
  EXPECT_NE(found.verdict, "");
}

TEST_F(SummaryOfARecording, HasMarksAndTheWorstClock) {
  put_overloaded(0, 0);
  for (const double uncertainty_s : {12e-6, 40e-6, 8e-6}) {
    const ClockFit fit{.node = 1,
                       .epoch = test::kEpoch,
                       .number = 1,
                       .state = ClockState::kLocked,
                       .host_ns = 1,
                       .node_ns = 1,
                       .uncertainty_s = uncertainty_s};
    writer->append(clock_fit_channel(1), encode(fit), 5'000'000);
  }
  writer->append(kNoteChannel,
                 encode(Note{.time_us = 7'000'000, .kind = NoteKind::kMark, .a = 1, .text = "weights"}),
                 7'000'000);
  // The same mark, noted again by a recorder that could not know whether it was on the disk.
  writer->append(kNoteChannel,
                 encode(Note{.time_us = 7'500'000, .kind = NoteKind::kMark, .a = 1, .text = "weights"}),
                 7'500'000);
  writer->append(kNoteChannel, encode(Note{.time_us = 8'000'000, .kind = NoteKind::kClock, .text = ""}),
                 8'000'000);
  put_end(20);
  const RecordingSummary found = summary();
  EXPECT_EQ(found.state, RecordingState::kComplete) << found.verdict;
  ASSERT_EQ(found.node.size(), 1U);
  EXPECT_EQ(found.node[0].sync_residual_s, 40e-6);
  EXPECT_EQ(found.marks, 1);
  ASSERT_EQ(found.mark.size(), 1U);
  EXPECT_EQ(found.mark[0].text, "weights");
  EXPECT_EQ(found.mark[0].time_us, 7'000'000);
  EXPECT_EQ(found.first_us, 5'000'000);
  EXPECT_EQ(found.last_us, 8'000'000);
}

TEST_F(SummaryOfARecording, OfWhatIsNoRecordingSaysSo) {
  writer.reset();
  std::filesystem::remove_all(folder);
  EXPECT_EQ(summary_of(folder).state, RecordingState::kUnreadable);
  EXPECT_NE(summary_of(folder).verdict, "");
}

}  // namespace
}  // namespace roadbalance
