#include "host/recording/formats/survey.hpp"

#include "common/bus/notes.hpp"
#include "common/test/source.hpp"
#include "host/recording/formats/export_table.hpp"
#include "host/recording/verify/test/written_record.hpp"

namespace roadbalance {
namespace {

class Survey : public test::WrittenRecord {
 protected:
  void put_vehicle() {
    for (MetaBlock part : split_text(MetaKind::kVehicleToml, test::read_source("sim/demo/vehicle.toml"))) {
      part.header = header(0, 0);
      put(part);
    }
  }
  /// 20 scans of 0.5 ms.
  void put_block(std::int64_t first_scan) {
    ScanBlock block;
    block.header = header(first_scan, 20);
    block.header.time_ns = first_scan * 500'000;
    block.period_ps = 500'000'000;
    put(block);
  }
  void put_mark(std::int64_t number, const std::string& text) {
    writer->append(kNoteChannel, encode(Note{.kind = NoteKind::kMark, .a = number, .text = text}), 0);
  }
};

// A recorder that was killed cannot know whether a mark had reached the disk.
TEST_F(Survey, AMarkThatWasNotedAgainIsOneMark) {
  put_vehicle();
  put_block(0);
  put_mark(1, "bridge");
  put_mark(2, "");
  put_block(20);
  put_mark(1, "bridge");
  put_mark(3, "");
  writer->close();
  const RecordingSurvey found = survey_recording(folder);
  ASSERT_EQ(found.mark.size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(found.mark[k].number, static_cast<std::int64_t>(k) + 1);
  EXPECT_EQ(found.mark[0].text, "bridge");
  EXPECT_EQ(found.mark[0].last_sample_ns, 10'000'000) << "when it was set";
  EXPECT_EQ(found.mark[2].last_sample_ns, 20'000'000);
}

// Any node on the bus is recorded.
TEST_F(Survey, GapsBeyondWhatClocksCanTellEndAtTheirLimit) {
  put_vehicle();
  put_block(0);
  constexpr std::int64_t kLost = kIndexLimit / 4;
  for (std::int64_t k = 0; k < 3; ++k) put_gap(20 + k * kLost, kLost, GapCause::kRingFull);
  writer->close();
  const RecordingSurvey found = survey_recording(folder);
  ASSERT_EQ(found.span.size(), 1U);
  EXPECT_EQ(found.span[0].next_scan, 20 + 3 * kLost);
  EXPECT_EQ(found.span[0].last_ns, kClockLimit_ns);
  ExportTable table = make_table(found);
  select({.from_s = 1e9}, table);
  EXPECT_EQ(table.group.at(0).first_ns, 1'000'000'000'000'000'000);
}

}  // namespace
}  // namespace roadbalance
