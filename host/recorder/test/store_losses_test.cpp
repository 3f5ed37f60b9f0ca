#include <array>

#include "common/bus/bus.hpp"
#include "host/recorder/event_outlet.hpp"
#include "host/recorder/test/store_drive.hpp"
#include "host/recording/verify/verify_journal.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using test::Drive;

class StoreLosses : public ::testing::Test, protected Drive {};

TEST_F(StoreLosses, TheJournalSaysEveryCounterOfLossOfNodeAndRecorder) {
  const BlockHeader& header = test::numbered_block(1).header;
  LinkCounters counters{.refused = 1, .rivals = 2, .unsent = 3, .node = {}};
  counters.node[{header.node, header.epoch}] = {.repaired = 4,
                                                .spool_failures = 5,
                                                .scans_refused = 6,
                                                .blocks_unsent = 7,
                                                .acks_refused = 8,
                                                .encoder_faults = {9, 10},
                                                .unreferenced_blocks = 11,
                                                .device_counts = {12, 13}};
  start();
  store->set_link_counters(counters);
  run(milliseconds(5000), 100);
  note_durable(store->close(now));
  int entries = 0;
  RecordReader reader(test::kFolder, disk);
  reader.finish();
  while (const auto event = reader.next()) {
    const auto entry = event->channel == kJournalChannel ? decode_journal(event->data) : std::nullopt;
    if (!entry) continue;
    ++entries;
    EXPECT_EQ(entry->node_losses, counters.node.begin()->second);
    EXPECT_EQ(entry->refused, 1);
    EXPECT_EQ(entry->rivals, 2);
    EXPECT_EQ(entry->unsent, 3);
  }
  EXPECT_GE(entries, 4) << "once a second";
}

// A node goes on counting when its last block has come.
TEST_F(StoreLosses, TheJournalSaysWhatIsLostBehindTheLastBlock) {
  const BlockHeader& header = test::numbered_block(1).header;
  LinkCounters counters{.node = {{{header.node, header.epoch}, {.repaired = 4}}}};
  start();
  store->set_link_counters(counters);
  run(milliseconds(3000), 60);
  run(milliseconds(2000), 0);  // an entry for the last of them
  counters.node.begin()->second.repaired = 5;
  store->set_link_counters(counters);
  note_durable(store->close(now));
  std::int64_t last = 0;
  RecordReader reader(test::kFolder, disk);
  reader.finish();
  while (const auto event = reader.next())
    if (const auto entry = event->channel == kJournalChannel ? decode_journal(event->data) : std::nullopt)
      last = entry->node_losses.repaired;
  EXPECT_EQ(last, 5);
}

// It may not have heard the node, of which it declares the crash.
TEST(JournalCheck, KeepsWhatANodeHasLostWhenItsRecorderBeginsAnew) {
  const NodeEpoch key{3, 77};
  JournalCheck check;
  Journal entry{.node = key.first, .epoch = key.second};
  entry.node_losses = {.blocks_unsent = 8, .device_counts = {0, 2}};
  entry.refused = 6;
  check.add(entry);
  check.restart();
  check.add(Journal{.node = key.first, .epoch = key.second});
  EXPECT_EQ(check.losses().at(key).node, entry.node_losses);
  EXPECT_EQ(check.losses().at(key).refused, 0) << "of the last run";
  EXPECT_TRUE(check.contradictions().empty());
  check.add(entry);
  check.add(Journal{.node = key.first, .epoch = key.second});
  EXPECT_FALSE(check.contradictions().empty()) << "in one run counts only rise";
}

// The first half is in the record when the recorder is started again.
TEST_F(StoreLosses, SaysWhenTheBlocksReceivedAreNotThoseThatTheEndSumsUp) {
  for (const std::uint32_t altered : {0u, 1u}) {
    Drive drive;
    drive.start();
    drive.run(milliseconds(1000), 20);
    drive.note_durable(drive.store->close(drive.now));
    drive.start();
    drive.run(milliseconds(1000), 20);
    BlockSum sum;
    for (std::int64_t k = 1; k <= 40; ++k) sum.add(test::numbered_block(k));
    const BlockHeader& last = test::numbered_block(40).header;
    SealedBlock end;
    seal(
        EndBlock{
            .header = {.node = last.node, .epoch = last.epoch, .sequence = 41, .first_scan = last.first_scan},
            .blocks_crc32c = sum.crc32c() ^ altered},
        end);
    drive.store->append(Delivery(end), drive.now);
    const auto warnings = drive.store->warnings();
    drive.note_durable(drive.store->close(drive.now));
    const auto notes = drive.notes(NoteKind::kEndContradicts);
    ASSERT_EQ(notes.size(), altered);
    EXPECT_EQ(warnings.size(), altered);
    if (altered == 0) continue;
    EXPECT_EQ(notes[0].a, last.node);
    EXPECT_EQ(notes[0].b, 41);
  }
}

// A disk that fails for hours while a device comes and goes, alarms flap and people ask: memory is bounded, a
// mark is never lost, and the record declares how much else is.
TEST_F(StoreLosses, NotesOfALongFailureAreBoundedAndWhatIsDroppedIsDeclared) {
  constexpr int kMost = HeldEvents::kMostNotes, kDropped = 300;
  constexpr std::array kKinds{NoteKind::kDevice, NoteKind::kAsked, NoteKind::kAlarmBegan,
                              NoteKind::kAlarmEnded};
  start();
  run(milliseconds(1000), 20);
  fail_syncs(EIO);
  run(milliseconds(1000), 20);
  for (int k = 0; k < kMost + kDropped; ++k) {
    store->note(kKinds[static_cast<std::size_t>(k) % kKinds.size()], k, 0, "again");
    store->note(NoteKind::kMark, k + 1, 0, "mark");
    store->note(NoteKind::kSegmentDeleted, k + 1, 0, "");
    run(milliseconds(10));
  }
  EXPECT_TRUE(notes(NoteKind::kMark).empty());
  fail_nothing();
  run(milliseconds(2000));
  store->note(NoteKind::kAsked, -1, 0, "after it");
  note_durable(store->close(now));
  EXPECT_EQ(durable, given);
  const auto marks = notes(NoteKind::kMark);
  ASSERT_EQ(marks.size(), static_cast<std::size_t>(kMost + kDropped));
  for (std::size_t k = 0; k < marks.size(); ++k) EXPECT_EQ(marks[k].a, static_cast<std::int64_t>(k) + 1);
  EXPECT_EQ(notes(NoteKind::kSegmentDeleted).size(), marks.size());
  for (const NoteKind kind : {NoteKind::kDevice, NoteKind::kAlarmBegan, NoteKind::kAlarmEnded})
    EXPECT_EQ(notes(kind).size(), static_cast<std::size_t>(kMost) / kKinds.size());
  const auto asked = notes(NoteKind::kAsked);
  EXPECT_EQ(asked.size(), static_cast<std::size_t>(kMost) / kKinds.size() + 1) << "there is memory again";
  EXPECT_EQ(asked.back().text, "after it");
  std::vector<std::string> declared;
  for (const Note& note : notes(NoteKind::kDiskFailed))
    if (note.text.find("not kept") != std::string::npos) declared.push_back(note.text);
  EXPECT_EQ(declared,
            std::vector<std::string>{
                "300 notes of devices, of alarms and of what was asked were not kept: no memory for more"});
}

// While the writer waits for its disk the nodes' clocks are measured on.
TEST_F(StoreLosses, MeasurementsOfClocksThatFoundNoRoomOnTheirWayToTheWriterAreDeclared) {
  auto [out, in] = make_channel<RecordEvent>(2);
  EventOutlet outlet(std::move(out));
  start();
  run(milliseconds(1000), 20);
  for (int k = 0; k < 7; ++k) outlet.put({"RB_CLOCK_1", {1}});
  for (int k = 0; k < 2; ++k) store->append(in.receive().value(), now);
  for (int k = 0; k < 2; ++k) outlet.put({"RB_CLOCK_1", {1}});
  for (int k = 0; k < 2; ++k) store->append(in.receive().value(), now);
  run(milliseconds(1000), 20);
  note_durable(store->close(now));
  const auto declared = notes(NoteKind::kDiskFailed);
  ASSERT_EQ(declared.size(), 1u);
  EXPECT_EQ(declared[0].text, "5 measurements of the nodes' clocks were not kept: no memory for more");
}

// So that a reader of the record finds when the last of it is gone.
TEST_F(StoreLosses, ARecorderThatStopsSaysHowManyNodeEpochsTheRecordHoldsAndItsLastMark) {
  start();
  store->note(NoteKind::kMark, 5, 0, "bridge");
  store->close(now);
  ASSERT_EQ(notes(NoteKind::kStopped).size(), 1u) << "with a mark alone, too";
  EXPECT_EQ(notes(NoteKind::kStopped)[0].a, 0);
  EXPECT_EQ(notes(NoteKind::kStopped)[0].b, 5);
  start();
  run(milliseconds(1000), 20);
  note_durable(store->close(now));
  ASSERT_EQ(notes(NoteKind::kStopped).size(), 2u);
  EXPECT_EQ(notes(NoteKind::kStopped)[1].a, 1);
  EXPECT_EQ(notes(NoteKind::kStopped)[1].b, 0) << "none in this run";
}

}  // namespace
}  // namespace roadbalance
