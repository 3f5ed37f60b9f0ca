#include <gtest/gtest.h>

#include "common/bus/codec.hpp"
#include "common/bus/notes.hpp"
#include "common/record/journal_counters.hpp"
#include "common/record/record_writer.hpp"
#include "common/record/test/numbered_blocks.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "host/recording/recover/recover.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {
namespace {

using test::numbered_block;

class RecoverJournalTest : public ::testing::Test {
 protected:
  void start() {
    const Note note{.time_us = 1, .incarnation = 1, .kind = NoteKind::kStarted, .text = {}};
    writer.append(kNoteChannel, encode(note), 1);
  }
  void append(std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k <= last; ++k) writer.append(numbered_block(k), 1);
  }
  // The counts of the recorder in this run so far.
  void count(std::int64_t first, std::int64_t last, std::int64_t repaired, std::int64_t refused) {
    JournalCounters counters;
    for (std::int64_t k = first; k <= last; ++k) counters.add(numbered_block(k));
    Journal entry = counters.take(numbered_block(1).header.node, numbered_block(1).header.epoch);
    entry.node_losses.repaired = repaired;
    entry.refused = refused;
    writer.append(kJournalChannel, encode(entry), 1);
  }
  VerifiedEpoch recovered() {
    writer.close();
    EXPECT_EQ(verify_record("/old", disk).epoch.at(0).contradictions, std::vector<std::string>());
    recover({"/old"}, "/new", disk);
    const Verification result = verify_record("/new", disk);
    EXPECT_GT(result.journal_entries, 0);
    return result.epoch.at(0);
  }

  test::SimulatedDisk disk;
  RecordWriter writer{{.folder = "/old"}, disk};
};

// A recorder that was killed wrote no entry for its last blocks; the new entry covers them.
TEST_F(RecoverJournalTest, ARestartOfTheRecorderBetweenTwoEntriesContradictsNothing) {
  start();
  append(1, 50);
  start();
  append(51, 300);
  count(51, 300, 0, 0);
  EXPECT_EQ(recovered().contradictions, std::vector<std::string>());
}

// The entry of a recorder that began anew has the end of its own scans; this one has none.
TEST_F(RecoverJournalTest, ARunWithoutScansContradictsNothing) {
  start();
  append(1, 50);
  count(1, 50, 0, 0);
  start();
  SignalBlock signals;
  signals.header = {.node = numbered_block(1).header.node,
                    .epoch = numbered_block(1).header.epoch,
                    .sequence = 51,
                    .first_scan = kScansPerBlock};
  ASSERT_TRUE(signals.add({.signal = 3, .value = 1.0}));
  SealedBlock sealed;
  seal(signals, sealed);
  writer.append(sealed, 1);
  JournalCounters counters;
  counters.add(sealed);
  writer.append(kJournalChannel, encode(counters.take(sealed.header.node, sealed.header.epoch)), 1);
  EXPECT_EQ(recovered().contradictions, std::vector<std::string>());
}

TEST_F(RecoverJournalTest, CountsOfLossesGoAlongAndBeginAnewWithTheRecorder) {
  start();
  append(1, 200);
  count(1, 200, 7, 90);
  append(201, 400);
  start();
  append(401, 500);
  count(401, 500, 8, 2);
  append(501, 700);
  const VerifiedEpoch found = recovered();
  EXPECT_EQ(found.contradictions, std::vector<std::string>());
  EXPECT_EQ(found.losses.repaired, 8);
}

}  // namespace
}  // namespace roadbalance
