#include "host/recorder/control/node_receipts.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

NodeReport epoch(std::int32_t node, std::int64_t number, std::int64_t samples) {
  return {.node = node,
          .epoch = number,
          .samples_sent = samples,
          .samples_recorded = samples,
          .repaired = 2,
          .blocks = 10,
          .ended = true,
          .overload_s = 0.5,
          .blocks_crc32c = static_cast<std::uint32_t>(number),
          .sums_agree = true};
}

TEST(Receipts, SumTheEpochsOfEachNode) {
  RecorderReport report;
  report.earlier = {epoch(2, 1, 100)};
  report.node = {epoch(1, 7, 1000), epoch(2, 9, 50)};
  report.node[1].ended = false;
  report.node[1].sums_agree.reset();
  const auto receipts = receipts_of(
      report, {.name = "drive", .incarnation = 3, .bytes = 77, .marks = 4, .sync_us = {{2, 12.5}}});
  ASSERT_EQ(receipts.size(), 2u);
  EXPECT_EQ(receipts[0].node, 1);
  EXPECT_EQ(receipts[0].samples_recorded, 1000);
  EXPECT_EQ(receipts[0].sums_agree, true);
  EXPECT_LT(receipts[0].sync_us, 0);
  EXPECT_EQ(receipts[1].node, 2);
  EXPECT_EQ(receipts[1].epochs, 2);
  EXPECT_EQ(receipts[1].open_epochs, 1);
  EXPECT_EQ(receipts[1].samples_sent, 150);
  EXPECT_EQ(receipts[1].repaired, 4);
  EXPECT_EQ(receipts[1].overload_s, 1.0);
  EXPECT_EQ(receipts[1].sync_us, 12.5);
  EXPECT_EQ(receipts[1].sums_agree, true) << "of the epoch that has an end";
  EXPECT_EQ(receipts[1].index, 1);
  EXPECT_EQ(receipts[1].nodes, 2);
  EXPECT_EQ(receipts[1].bytes, 77);
  for (const Receipt& receipt : receipts) EXPECT_TRUE(decode_receipt(encode(receipt)));
}

TEST(Receipts, NameANodeThatNeverCameAndWhatEndedAnother) {
  RecorderReport report;
  report.node = {epoch(1, 7, 1000), epoch(2, 9, 50)};
  report.absence = {{.node = 2, .cause = AbsenceCause::kDeviceFailed, .seconds = 38, .to_end = true},
                    {.node = 3, .cause = AbsenceCause::kNeverCame, .from_begin = true, .to_end = true}};
  const auto receipts = receipts_of(report, {.name = "drive", .stopped_by = "rb of anna at laptop"});
  ASSERT_EQ(receipts.size(), 3u);
  EXPECT_EQ(receipts[0].absence, "");
  EXPECT_EQ(receipts[1].absence,
            "ended 38 s before the recording: its device failed: look at its cable and supply");
  EXPECT_EQ(receipts[2].absence, "never came");
  EXPECT_EQ(receipts[2].epochs, 0);
  for (const Receipt& receipt : receipts) {
    EXPECT_EQ(receipt.nodes, 3);
    EXPECT_EQ(receipt.stopped_by, "rb of anna at laptop");
    EXPECT_TRUE(decode_receipt(encode(receipt)));
  }
}

TEST(Receipts, OfANodeThatWasOnlyNotHeardAreWholeOnceItHasToldItsEnd) {
  RecorderReport first;
  first.node = {epoch(2, 9, 800)};
  first.node[0].ended = false;
  first.absence = {{.node = 2, .cause = AbsenceCause::kProgramEnded, .seconds = 5},
                   {.node = 2, .cause = AbsenceCause::kSilent, .seconds = 38, .to_end = true}};
  const auto before = receipts_of(first, {.name = "drive"});
  ASSERT_NE(before.at(0).unheard.find("was not heard"), std::string::npos);
  RecorderReport second;
  second.node = {epoch(2, 9, 900)};
  const auto after = completed(before, second, 5);
  EXPECT_EQ(after.at(0).absence,
            "was away for 5.0 s: its program was ended: by its service, a person or a closed terminal");
  EXPECT_EQ(after.at(0).unheard, "");
  second.node[0].ended_early = true;
  EXPECT_NE(completed(before, second, 5).at(0).unheard, "") << "it did not measure to the stop";
}

// The folder knows neither overload nor repairs of the run before.
TEST(Receipts, AreCompletedByTheRunThatFetchedTheRest) {
  RecorderReport first;
  first.node = {epoch(1, 7, 1000), epoch(2, 9, 800)};
  first.node[1].ended = false;
  first.node[1].sums_agree.reset();
  first.node[1].samples_sent = 900;  // by its last heartbeat
  const auto before =
      receipts_of(first, {.name = "drive", .began_us = 5, .ended_us = 6, .marks = 4, .sync_us = {{1, 2.5}}});
  ASSERT_EQ(before.at(1).open_epochs, 1);
  RecorderReport second;
  second.earlier = {epoch(1, 7, 1000)};
  second.earlier[0].repaired = 0;
  second.earlier[0].overload_s = 0;
  second.node = {epoch(2, 9, 1500)};
  second.node[0].repaired = 30;
  const auto after = completed(before, second, 99);
  ASSERT_EQ(after.size(), 2u);
  EXPECT_EQ(after[0].repaired, 2);
  EXPECT_EQ(after[0].overload_s, 0.5);
  EXPECT_EQ(after[0].sync_us, 2.5);
  EXPECT_EQ(after[1].open_epochs, 0);
  EXPECT_EQ(after[1].sums_agree, true);
  EXPECT_EQ(after[1].samples_recorded, 1500);
  EXPECT_EQ(after[1].samples_sent, 1500);
  EXPECT_EQ(after[1].repaired, 30);
  EXPECT_EQ(after[1].overload_s, 1.0);
  for (const Receipt& receipt : after) {
    EXPECT_EQ(receipt.name, "drive");
    EXPECT_EQ(receipt.ended_us, 6) << "who shows receipts knows them by it";
    EXPECT_EQ(receipt.marks, 4);
    EXPECT_EQ(receipt.bytes, 99);
  }
  auto contradicted = before;
  contradicted[0].sums_agree = false;
  EXPECT_EQ(completed(contradicted, second, 99).at(0).sums_agree, false) << "whatever the folder says";
}

// Its sum was never reported: that it does not agree would be a reason to look for damage.
TEST(Receipts, OfANodeThatCrashedHaveNoEnd) {
  RecorderReport report;
  report.node = {epoch(1, 7, 1000), epoch(1, 8, 1000)};
  report.node[0].crashed = true;
  report.node[0].sums_agree.reset();
  const auto receipts = receipts_of(report, {.name = "drive"});
  ASSERT_EQ(receipts.size(), 1u);
  EXPECT_EQ(receipts[0].epochs, 2);
  EXPECT_EQ(receipts[0].open_epochs, 1);
  EXPECT_EQ(receipts[0].sums_agree, true);
  report.node[1].sums_agree = false;
  EXPECT_EQ(receipts_of(report, {.name = "drive"}).at(0).sums_agree, false) << "the end of the other says so";
}

TEST(Receipts, DoNotClaimADamageWhereBlocksWereLost) {
  RecorderReport report;
  report.node = {epoch(1, 7, 1000), epoch(1, 8, 1000)};
  report.node[0].sums_agree.reset();
  EXPECT_EQ(receipts_of(report, {.name = "drive"}).at(0).sums_agree, std::nullopt);
  EXPECT_EQ(receipts_of(report, {.name = "drive"}).at(0).open_epochs, 0);
  report.node[1].sums_agree = false;
  EXPECT_EQ(receipts_of(report, {.name = "drive"}).at(0).sums_agree, false);
}

// It reported that it took samples, and no block of it ever came.
TEST(Receipts, OfANodeThatTheFolderKnowsNothingOfStaysOpen) {
  RecorderReport first;
  first.node = {epoch(1, 7, 1000), epoch(2, 9, 0)};
  first.node[0].ended = false;
  first.node[0].sums_agree.reset();
  first.node[1] = NodeReport{.node = 2, .epoch = 9, .samples_sent = 900};
  const auto before = receipts_of(first, {.name = "drive", .began_us = 5, .ended_us = 6});
  ASSERT_EQ(before.size(), 2u);
  RecorderReport second;
  second.node = {epoch(1, 7, 1500)};
  const auto after = completed(before, second, 99);
  ASSERT_EQ(after.size(), 2u);
  EXPECT_EQ(after[0].open_epochs, 0);
  EXPECT_EQ(after[1].node, 2);
  EXPECT_EQ(after[1].open_epochs, 1);
  EXPECT_EQ(after[1].samples_sent, 900);
  EXPECT_EQ(after[1].index, 1);
  EXPECT_EQ(after[1].nodes, 2);
}

// Its cable went before it reported any samples.
TEST(Receipts, ANodeThatWasStartedAndFellSilentAtOnceStaysOpen) {
  RecorderReport report;
  report.node = {epoch(1, 7, 1000), NodeReport{.node = 2, .epoch = 9, .started = true}};
  const auto receipts = receipts_of(report, {.name = "drive"});
  ASSERT_EQ(receipts.size(), 2u);
  EXPECT_EQ(receipts[1].node, 2);
  EXPECT_EQ(receipts[1].open_epochs, 1);
  EXPECT_EQ(receipts[1].samples_recorded, 0);
}

TEST(Receipts, ANodeThatOnlyWaitedHasNone) {
  RecorderReport report;
  report.node = {NodeReport{.node = 1, .epoch = 4}};
  const auto receipts = receipts_of(report, {.name = "drive"});
  ASSERT_EQ(receipts.size(), 1u);
  EXPECT_EQ(receipts[0].nodes, 0);
  EXPECT_EQ(receipts[0].name, "drive");
  EXPECT_TRUE(decode_receipt(encode(receipts[0])));
}

}  // namespace
}  // namespace roadbalance
