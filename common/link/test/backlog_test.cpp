#include "common/link/backlog.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <random>
#include <vector>

#include "common/link/spool.hpp"

namespace roadbalance {
namespace {

/// A spool that refuses and forgets as set.
class MemorySpool final : public Spool {
 public:
  std::int64_t base() const override { return base_; }
  std::int64_t next() const override { return base_ + static_cast<std::int64_t>(blocks_.size()); }
  std::int64_t capacity() const override { return room; }
  std::int64_t failures() const override { return failures_; }
  void describe(const SealedBlock& meta) override { described.push_back(meta.header.sequence); }
  void keep(const Ring& ring, std::int64_t first, std::int64_t last, WallTime) override {
    if (last - first >= most_at_once) {
      ++failures_;
      return;
    }
    if (blocks_.empty()) base_ = first;
    for (std::int64_t k = first; k <= last && static_cast<std::int64_t>(blocks_.size()) < room; ++k)
      blocks_.push_back(ring.get(k));
  }
  void never_wait() override {}
  bool read(std::int64_t sequence, SealedBlock& out) override {
    if (sequence == unreadable || all_unreadable) return false;
    out = blocks_.at(static_cast<std::size_t>(sequence - base_));
    return true;
  }
  bool answers() override { return !all_unreadable || answers_all_the_same; }
  void free_through(std::int64_t sequence) override {
    for (; base_ <= sequence; ++base_) blocks_.pop_front();
  }
  void give_up_through(std::int64_t sequence) override { free_through(sequence); }

  std::int64_t room = 1000;
  std::int64_t most_at_once = 1000;  // of more it takes none
  std::int64_t unreadable = 0;
  bool all_unreadable = false;
  bool answers_all_the_same = false;
  std::vector<std::int64_t> described;

 private:
  std::int64_t failures_ = 0;
  std::int64_t base_ = 1;
  std::deque<SealedBlock> blocks_;
};

constexpr WallTime kNow{std::chrono::hours(1)};

void put_into(Ring& ring) {
  SealedBlock* block = ring.claim();
  ASSERT_NE(block, nullptr);
  block->kind = BlockKind::kScan;
  block->header.sequence = ring.next();
  block->size = static_cast<std::uint32_t>(ring.next() % 1000);
  ring.commit();
}

struct BacklogTest : testing::Test {
  Ring ring{32 * sizeof(SealedBlock)};
  MemorySpool spool;
  Backlog backlog{ring, &spool};

  void put(int blocks) {
    for (int k = 0; k < blocks; ++k) put_into(ring);
  }
};

TEST_F(BacklogTest, IsTheRingAloneWithoutASpool) {
  Backlog alone(ring);
  put(20);
  alone.relieve(kNow);
  EXPECT_EQ(alone.used(), 20);
  EXPECT_EQ(alone.capacity(), 32);
  EXPECT_EQ(alone.spooled(), 0);
  alone.free_through(5);
  EXPECT_EQ(alone.base(), 6);
  EXPECT_EQ(alone.get(6)->header.sequence, 6);
}

TEST_F(BacklogTest, MovesTheOldestOnceMoreThanHalfOfTheRingIsUsed) {
  put(16);
  backlog.relieve(kNow);
  EXPECT_EQ(backlog.spooled(), 0);
  put(1);
  backlog.relieve(kNow);
  EXPECT_EQ(backlog.spooled(), 2);
  EXPECT_EQ(ring.used(), 15);
  EXPECT_EQ(backlog.base(), 1);
  EXPECT_EQ(backlog.used(), 17);
}

TEST_F(BacklogTest, KeepsInTheRingWhatTheSpoolRefuses) {
  put(20);
  spool.room = 0;
  backlog.relieve(kNow);
  EXPECT_EQ(ring.used(), 20);
  EXPECT_EQ(backlog.base(), 1);
}

TEST_F(BacklogTest, SavesEverythingAtTheEnd) {
  put(10);
  backlog.save(kNow);
  EXPECT_EQ(backlog.spooled(), 10);
  EXPECT_EQ(ring.used(), 0);
  EXPECT_EQ(backlog.get(10)->header.sequence, 10);
}

TEST_F(BacklogTest, SavesInSmallPiecesWhatADiskThatIsNearlyFullRefusesInOne) {
  put(20);
  spool.most_at_once = 2;
  backlog.save(kNow);
  EXPECT_EQ(backlog.spooled(), 20);
}

TEST_F(BacklogTest, SavingEndsWhenTheSpoolIsFullAndWhenItRefusesEverything) {
  put(20);
  spool.most_at_once = 0;
  backlog.save(kNow);
  EXPECT_EQ(backlog.spooled(), 0);
  spool.most_at_once = 1000;
  spool.room = 7;
  backlog.save(kNow);
  EXPECT_EQ(backlog.spooled(), 7);
}

TEST_F(BacklogTest, TellsTheSpoolWhatDescribesTheEpochAndNothingElse) {
  for (int k = 0; k < 3; ++k) {
    SealedBlock* block = ring.claim();
    block->kind = BlockKind::kMeta;
    block->header.sequence = ring.next();
    ring.commit();
    backlog.relieve(kNow);
  }
  backlog.free_through(2);
  put(1);
  backlog.relieve(kNow);
  SealedBlock* late = ring.claim();
  late->kind = BlockKind::kMeta;
  late->header.sequence = ring.next();
  ring.commit();
  backlog.relieve(kNow);
  EXPECT_EQ(spool.described, (std::vector<std::int64_t>{1, 2, 3}));
}

TEST_F(BacklogTest, GivesUpABlockThatTheDiskDoesNotGiveBackOnceItIsTheOldest) {
  put(20);
  backlog.relieve(kNow);  // 1 and 2
  spool.unreadable = 2;
  for (int k = 0; k < 100; ++k) EXPECT_EQ(backlog.get(2), nullptr);
  EXPECT_EQ(backlog.base(), 1) << "the one before it is still good";
  backlog.free_through(1);
  for (int k = 0; k < Backlog::kMostTries; ++k) EXPECT_EQ(backlog.get(2), nullptr);
  EXPECT_EQ(backlog.base(), 3);
}

class BacklogWhoseDiskIsGone : public BacklogTest {
 protected:
  BacklogWhoseDiskIsGone() {
    put(30);
    for (int k = 0; k < 5; ++k) backlog.relieve(kNow);
    spool.all_unreadable = true;
  }
  void ask_for_the_oldest(int times) {
    for (int k = 0; k < times; ++k) EXPECT_EQ(backlog.get(backlog.base()), nullptr);
  }
};

TEST_F(BacklogWhoseDiskIsGone, WaitsForItAndLosesNothing) {
  ASSERT_EQ(backlog.spooled(), 10);
  ask_for_the_oldest(100 * Backlog::kMostTries);
  EXPECT_EQ(backlog.base(), 1);
  spool.all_unreadable = false;
  for (std::int64_t k = 1; k <= 10; ++k) EXPECT_NE(backlog.get(k), nullptr) << k;
}

TEST_F(BacklogTest, GivesUpABadPieceOfADiskThatAnswersAtOnce) {
  put(30);
  for (int k = 0; k < 5; ++k) backlog.relieve(kNow);
  spool.all_unreadable = spool.answers_all_the_same = true;
  for (int k = 0; k < Backlog::kMostTries; ++k) EXPECT_EQ(backlog.get(1), nullptr);
  for (std::int64_t k = 2; k <= 5; ++k) {
    EXPECT_EQ(backlog.base(), k);
    EXPECT_EQ(backlog.get(k), nullptr);
  }
  spool.all_unreadable = false;
  EXPECT_NE(backlog.get(6), nullptr);
}

// It must not keep the memory behind it full.
TEST_F(BacklogWhoseDiskIsGone, GivesTheRestUpWhenTheRingIsNearlyFull) {
  put(5);
  ASSERT_GT(ring.used() * 4, ring.capacity() * 3);
  ask_for_the_oldest(Backlog::kMostTries);
  EXPECT_EQ(backlog.base(), 11);
}

// Else blocks in the ring would reach no recorder.
TEST_F(BacklogWhoseDiskIsGone, GivesTheRestUpAtTheEnd) {
  SealedBlock* end = ring.claim();
  end->kind = BlockKind::kEnd;
  end->header.sequence = ring.next();
  ring.commit();
  ask_for_the_oldest(Backlog::kMostTriesAtEnd - 1);
  EXPECT_EQ(backlog.base(), 1);
  ask_for_the_oldest(1);
  EXPECT_EQ(backlog.base(), 11);
}

// Against a plain queue, with a spool of changing room that refuses now and then.
TEST_F(BacklogTest, IsOneRunOfSequencesWhateverTheSpoolDoes) {
  for (int seed = 1; seed <= 30; ++seed) {
    Ring small(32 * sizeof(SealedBlock));
    MemorySpool disk;
    Backlog both(small, &disk);
    std::mt19937 random(static_cast<unsigned>(seed));
    const auto up_to = [&random](std::int64_t most) {
      return static_cast<std::int64_t>(random() % static_cast<unsigned>(most + 1));
    };
    std::deque<std::int64_t> model;
    for (int step = 0; step < 3000; ++step) {
      disk.room = up_to(3) == 0 ? 0 : up_to(200);
      for (std::int64_t k = up_to(6); k > 0 && small.claim(); --k) {
        model.push_back(small.next());
        put_into(small);
      }
      both.relieve(kNow);
      if (up_to(4) == 0 && !model.empty()) {
        const std::int64_t through = model.front() - 1 + up_to(static_cast<std::int64_t>(model.size()));
        both.free_through(through);
        while (!model.empty() && model.front() <= through) model.pop_front();
      }
      ASSERT_EQ(both.used(), static_cast<std::int64_t>(model.size()));
      ASSERT_EQ(both.next(), small.next());
      if (model.empty()) continue;
      ASSERT_EQ(both.base(), model.front());
      const std::int64_t any = both.base() + up_to(both.used() - 1);
      const SealedBlock* block = both.get(any);
      ASSERT_NE(block, nullptr);
      ASSERT_EQ(block->header.sequence, any);
      ASSERT_EQ(block->size, any % 1000);
    }
    EXPECT_GT(small.next(), 1000);
  }
}

}  // namespace
}  // namespace roadbalance
