#include "host/recorder/epoch_counters.hpp"

#include <gtest/gtest.h>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

// A recorder that was started again must not forget what the one before has missed.
TEST(EpochCounters, CountsWhatARecoveredEpochLacks) {
  RecordState recovered;
  recovered.epoch[{2, 8}] = {
      .position = {.contiguous = 6, .next_scan = 100, .ended = true}, .samples = 60, .gaps = 1, .blocks = 6};
  const RecorderReport report = EpochCounters(recovered).report();
  ASSERT_EQ(report.earlier.size(), 1u);
  EXPECT_EQ(report.earlier[0].samples_sent, 100);
  EXPECT_EQ(report.earlier[0].samples_recorded, 60);
}

TEST(EpochCounters, ARecoveredEndAgreesOnlyWhereTheRecordKnowsIt) {
  RecordState recovered;
  recovered.epoch[{1, 8}] = {.position = {.contiguous = 6, .ended = true}, .sum = 0x12ab};
  recovered.epoch[{2, 8}] = {.position = {.contiguous = 6, .ended = true}, .sum = std::nullopt};
  recovered.epoch[{3, 8}] = {.position = {.contiguous = 6}, .sum = 0x12ab};
  const RecorderReport report = EpochCounters(recovered).report();
  ASSERT_EQ(report.earlier.size(), 3u);
  EXPECT_EQ(report.earlier[0].sums_agree, true);
  EXPECT_EQ(report.earlier[1].sums_agree, std::nullopt);
  EXPECT_EQ(report.earlier[2].sums_agree, std::nullopt) << "it has no end";
}

// Its end contradicts its blocks: the sums say so, and no loss is negative.
TEST(EpochCounters, AnEndThatCountsTooFewLosesNothing) {
  EpochCounters counters({});
  ScanBlock scans{.header = {.node = 2, .epoch = 8, .sequence = 1, .scans = 20}, .period_ps = 500'000'000};
  SealedBlock sealed;
  seal(scans, sealed);
  counters.take(sealed);
  seal(EndBlock{.header = {.node = 2, .epoch = 8, .sequence = 2, .first_scan = 20},
                .blocks = 2,
                .scans_sealed = 10},
       sealed);
  counters.take(sealed);
  const RecorderReport report = counters.report();
  ASSERT_EQ(report.earlier.size(), 1u);
  EXPECT_EQ(report.earlier[0].samples_sent, report.earlier[0].samples_recorded);
  EXPECT_EQ(report.earlier[0].sums_agree, false);
}

// Its last heartbeat is older than the last block it sent.
TEST(EpochCounters, ANodeThatDiedHasLostNothingOfWhatIsRecorded) {
  EpochCounters counters({});
  counters.take(Heartbeat{.node = 2, .epoch = 8, .scans_sampled = 30});
  SealedBlock sealed;
  for (const std::int64_t first_scan : {0, 20, 60}) {
    ScanBlock scans{.header = {.node = 2,
                               .epoch = 8,
                               .sequence = 1 + first_scan / 20,
                               .first_scan = first_scan,
                               .scans = 20},
                    .period_ps = 500'000'000};
    seal(scans, sealed);
    counters.take(sealed);
  }
  const RecorderReport report = counters.report();
  ASSERT_EQ(report.node.size(), 1u);
  EXPECT_EQ(report.node[0].samples_sent, 80) << "20 of them have not come";
  EXPECT_EQ(report.node[0].samples_recorded, 60);
}

}  // namespace
}  // namespace roadbalance
