#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "common/types/blocks.hpp"
#include "host/recorder/test/store_drive.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

constexpr std::int32_t kNode = 2;
constexpr std::int64_t kEpoch = 5;
constexpr std::int64_t kBlocks = 100;
constexpr std::int64_t kAhead = 50;  // blocks and scans begin so far before the number

/// Where a node stands after months: block numbers and scan indexes about to pass 2^31 or 2^32.
struct Passing {
  std::int64_t block;
  std::int64_t scan;
};

class LargeNumbers : public ::testing::TestWithParam<Passing>, protected test::Drive {
 protected:
  // The number of a block that ends at 2^31 or 2^32, and the scan it begins with.
  const std::int64_t first_block = GetParam().block - kAhead;
  const std::int64_t first_scan = GetParam().scan - kAhead * kScansPerBlock - 7;

  BlockHeader header(std::int64_t k, std::int64_t scans) const {
    return {.node = kNode,
            .epoch = kEpoch,
            .sequence = first_block + k,
            .first_scan = first_scan + k * kScansPerBlock,
            .scans = scans,
            .time_ns = k * 10'000'000};
  }
  SealedBlock scans(std::int64_t k) const {
    SealedBlock sealed;
    ScanBlock block;
    block.header = header(k, kScansPerBlock);
    block.period_ps = 500'000'000;
    seal(block, sealed);
    return sealed;
  }
  SealedBlock end() const {
    SealedBlock sealed;
    const BlockHeader behind = header(kBlocks, 0);
    seal(EndBlock{.header = behind,
                  .blocks = behind.sequence,
                  .scans_sealed = behind.first_scan,
                  .scans_missing = 0},
         sealed);
    return sealed;
  }
  void take(EpochReceiver& receiver, const SealedBlock& block) {
    std::vector<Delivery> out;
    EXPECT_EQ(receiver.block(block, now, out), EpochReceiver::Take::kAccepted) << block.header.sequence;
    for (const Delivery& delivery : out) store->append(delivery, now);
  }
  void commit(EpochReceiver& receiver) {
    for (const DurableMark& mark : store->commit(now += milliseconds(300))) receiver.durable(mark.sequence);
  }
};

// A recorder joins, asks for the hole that the number lies in, is started again, and ends.
TEST_P(LargeNumbers, AreRecordedRecoveredAndProvenAsSmallOnes) {
  start();
  EpochReceiver receiver(kNode, kEpoch, {}, {});
  std::vector<Delivery> out;
  Heartbeat heartbeat;
  heartbeat.node = kNode;
  heartbeat.epoch = kEpoch;
  heartbeat.base = first_block;
  heartbeat.next = first_block + kBlocks;
  receiver.heartbeat(heartbeat, now, out);
  for (const Delivery& delivery : out) store->append(delivery, now);
  EXPECT_GE(receiver.credit(), first_block) << "what is gone at the node is not waited for";

  const std::int64_t hole = kAhead - 2, behind_hole = kAhead + 3;
  for (std::int64_t k = 0; k < kBlocks; ++k)
    if (k < hole || k >= behind_hole) take(receiver, scans(k));
  const Ack asks = receiver.acknowledge(now += milliseconds(20));
  ASSERT_EQ(asks.missing.size(), 1u);
  EXPECT_EQ(asks.missing[0].first, first_block + hole);
  EXPECT_EQ(asks.missing[0].last, first_block + behind_hole - 1);
  for (std::int64_t k = hole; k < behind_hole; ++k) take(receiver, scans(k));
  commit(receiver);
  EXPECT_EQ(receiver.durable(), first_block + kBlocks - 1);

  store.reset();
  start();
  const auto& recovered = store->recovered().epoch.at({kNode, kEpoch});
  EXPECT_EQ(recovered.position.contiguous, first_block + kBlocks - 1);
  EXPECT_EQ(recovered.position.next_scan, first_scan + kBlocks * kScansPerBlock);
  EpochReceiver again(kNode, kEpoch, recovered.position, {});
  take(again, end());
  commit(again);
  store->close(now);

  const Verification v = verify_record(test::kFolder, disk);
  EXPECT_EQ(v.verdict, Verdict::kIncomplete) << verdict_text(v) << (v.damage.empty() ? "" : v.damage.front());
  ASSERT_EQ(v.epoch.size(), 1u);
  EXPECT_EQ(v.epoch[0].samples, kBlocks * kScansPerBlock);
  EXPECT_EQ(v.epoch[0].samples_missing, first_scan);
  ASSERT_EQ(v.epoch[0].gaps.size(), 1u);
  EXPECT_EQ(v.epoch[0].gaps[0].first_block, 1);
  EXPECT_EQ(v.epoch[0].gaps[0].sequence, first_block - 1);
  EXPECT_TRUE(v.epoch[0].contradictions.empty()) << v.epoch[0].contradictions.front();
  EXPECT_GT(v.journal_entries, 0);
}

constexpr std::int64_t k31 = std::int64_t{1} << 31, k32 = std::int64_t{1} << 32;
INSTANTIATE_TEST_SUITE_P(Limits, LargeNumbers,
                         ::testing::Values(Passing{k31, k32}, Passing{k32, k31}, Passing{k32, k32},
                                           Passing{k31, std::int64_t{1} << 40}));

}  // namespace
}  // namespace roadbalance
