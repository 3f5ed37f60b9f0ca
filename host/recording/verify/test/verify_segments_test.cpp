#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>

#include "common/bus/codec.hpp"
#include "common/bus/notes.hpp"
#include "common/record/log_event.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_events.hpp"
#include "common/record/segment_index.hpp"
#include "common/types/crc32c.hpp"
#include "host/recording/manifest.hpp"
#include "host/recording/verify/test/written_record.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using test::kEpoch;

// Two finished segments, as a recorder leaves them that was not killed.
class VerifyFinished : public test::WrittenRecord {
 protected:
  VerifyFinished() {
    put_scans(0);
    put_scans(20);
    writer->close();
    writer.emplace(RecordWriter::Options{.folder = folder});
    put_scans(40);
    put_end(60);
    writer->close();
    write_manifest(folder);
  }
  Verdict verdict() const { return verify_record(folder).verdict; }
  fs::path segment(int number) const { return segment_path(folder, number); }
};

TEST_F(VerifyFinished, IsComplete) {
  EXPECT_EQ(verdict(), Verdict::kComplete);
}

TEST_F(VerifyFinished, WhatIsNoRegularFileIsNamedAndNotRead) {
  EXPECT_EQ(verify_record(folder).not_read, std::vector<std::string>{});
  ASSERT_EQ(mkfifo((folder / "notes.txt").c_str(), 0600), 0);
  fs::create_symlink("/etc/passwd", folder / "link.txt");
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kComplete);
  EXPECT_EQ(v.not_read, (std::vector<std::string>{"link.txt: is a link, which is not read",
                                                  "notes.txt: is a pipe, which is not read"}));
}

TEST_F(VerifyFinished, OneOfItsFilesThatIsNoRegularFileMakesItUnreadable) {
  fs::rename(folder / "manifest.json", folder / "away");
  fs::create_symlink(folder / "away", folder / "manifest.json");
  Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kUnreadable);
  EXPECT_NE(v.error.find("manifest.json: a link, which is not followed"), std::string::npos) << v.error;
  fs::rename(folder / "away", folder / "manifest.json");
  fs::remove(segment(2));
  ASSERT_EQ(mkfifo(segment(2).c_str(), 0600), 0);
  v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kUnreadable);
  EXPECT_NE(v.error.find("seg-000002.lcm: no regular file, which is not read"), std::string::npos) << v.error;
}

TEST_F(VerifyFinished, ASegmentCutShortIsDamageWhereverItIsCut) {
  const auto size = fs::file_size(segment(2));
  for (const auto kept : {size - 1, size / 2, size - (28 + 14 + 92), std::uintmax_t{0}}) {
    fs::resize_file(segment(2), kept);
    EXPECT_EQ(verdict(), Verdict::kDamaged) << kept << " of " << size << " bytes";
  }
}

TEST_F(VerifyFinished, ASegmentThatIsGoneIsDamage) {
  fs::remove(segment(2));
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  ASSERT_FALSE(v.damage.empty());
  EXPECT_NE(v.damage[0].find("seg-000002.lcm"), std::string::npos) << v.damage[0];
}

// The journal in a third segment proves the blocks that were appended in the first two.
class VerifyWithoutTheFirst : public VerifyFinished {
 protected:
  void put_journal_and_remove_the_first(std::optional<Note> note) {
    writer.emplace(RecordWriter::Options{.folder = folder});
    Journal journal{.node = 1, .epoch = kEpoch, .first_sequence = 1, .last_sequence = 4};
    journal.next_scan = journal.scans = 60;
    journal.channel_crc.fill(crc32c(std::vector<std::uint8_t>(4 * 60)));  // all counts are 0
    writer->append(kJournalChannel, encode(journal), 0);
    if (note) writer->append(kNoteChannel, encode(*note), 0);
    writer->close();
    ASSERT_EQ(verdict(), Verdict::kComplete);
    fs::remove(segment(1));
  }
};

TEST_F(VerifyWithoutTheFirst, TheRetentionModeSaysWhatItDeletes) {
  put_journal_and_remove_the_first(Note{.kind = NoteKind::kSegmentDeleted, .a = 1, .text = {}});
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kIncomplete) << verdict_text(v);
  ASSERT_EQ(v.epoch.size(), 1u);
  EXPECT_EQ(v.epoch[0].samples, 20);
  EXPECT_EQ(v.epoch[0].samples_deleted, 40);
  EXPECT_EQ(v.deleted_segments, 1);
  EXPECT_EQ(v.lost, std::vector<std::string>{"segment 1 was deleted by the retention mode"});
}

TEST_F(VerifyWithoutTheFirst, AnUndeclaredDeletionIsALoss) {
  put_journal_and_remove_the_first({});
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  ASSERT_EQ(v.epoch.size(), 1u);
  EXPECT_EQ(v.epoch[0].samples_deleted, 0);
  ASSERT_EQ(v.epoch[0].undeclared_blocks.size(), 1u);
  EXPECT_EQ(v.epoch[0].undeclared_blocks[0].last, 2);
  ASSERT_EQ(v.epoch[0].undeclared_scans.size(), 1u);
  EXPECT_EQ(v.epoch[0].undeclared_scans[0].last, 39);
  EXPECT_TRUE(std::ranges::any_of(v.epoch[0].contradictions, [](const std::string& line) {
    return line.starts_with("journal entry of blocks 1 to 4: ");
  }));
}

TEST_F(VerifyWithoutTheFirst, AnEpochThatWasAllInItIsNamedByTheJournalOnly) {
  put_journal_and_remove_the_first({});
  fs::remove(segment(2));
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  ASSERT_EQ(v.epoch.size(), 1u);
  EXPECT_EQ(v.epoch[0].blocks, 0);
  EXPECT_FALSE(v.epoch[0].contradictions.empty());
}

TEST_F(VerifyFinished, ASegmentLongerThanItWasFinishedIsDamage) {
  const auto header = encode_log_header({.channel = "OTHER_PROGRAM", .data = {}});
  std::ofstream(segment(2), std::ios::binary | std::ios::app)
      << std::string(header.begin(), header.end()) << "OTHER_PROGRAM";
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  EXPECT_EQ(v.missing_segments, 1);
}

// A cut between events tears nothing, and without a manifest only the index proves it.
TEST_F(VerifyFinished, AnIndexProvesThatItsSegmentWasLonger) {
  fs::remove(folder / "manifest.json");
  fs::resize_file(segment(2), fs::file_size(segment(2)) - commit_event_bytes());
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  ASSERT_EQ(v.damage.size(), 1u);
  EXPECT_NE(v.damage[0].find("seg-000002.lcm: has "), std::string::npos) << v.damage[0];
  fs::remove(index_path(folder, 2));
  EXPECT_EQ(verdict(), Verdict::kComplete) << "all is there but a commit, as a kill may leave it";
}

TEST_F(VerifyFinished, AnIndexProvesThatThereWasASegment) {
  put_scans(60);
  writer.emplace(RecordWriter::Options{.folder = folder});
  SealedBlock end;
  seal(EndBlock{.header = {.node = 2, .epoch = 7, .sequence = 1}, .blocks = 1}, end);
  writer->append(end, 0);
  writer->close();
  fs::remove(folder / "manifest.json");
  ASSERT_EQ(verdict(), Verdict::kComplete);
  fs::remove(segment(3));
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  EXPECT_EQ(v.damage, std::vector<std::string>{"seg-000003.lcm: is missing; its index is here"});
}

// The segment is as long as its index has it or longer, and good in itself.
TEST_F(VerifyFinished, AnEpochThatOnlyAnIndexKnowsIsDamage) {
  fs::remove(folder / "manifest.json");
  SegmentIndex index = *read_index(folder, 2);
  index.bytes -= 1;
  index.epoch[{2, 7}] = {};
  write_index(folder, index);
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  EXPECT_EQ(v.damage,
            std::vector<std::string>{"seg-000002.lcm: node 2 epoch 7 is not here; its index names it"});
  std::ofstream(folder / "continues") << "/first\n";
  const Verification continued = verify_record(folder);
  EXPECT_EQ(continued.missing_segments, 0) << "it is in the folder that this one continues";
}

// A fallback folder is no complete recording, but it is sound.
class VerifyContinued : public test::WrittenRecord {
 protected:
  VerifyContinued() {
    RecordState before;
    before.epoch[{1, kEpoch}] = {
        .position = {.contiguous = 10, .next_scan = 200}, .samples = 200, .blocks = 10, .sum = 5};
    writer.emplace(RecordWriter::Options{.folder = folder}, kernel_disk(), before);
    sequence = 10;
    sum = BlockSum(5);
    put_scans(200);
    writer->close();
    writer.emplace(RecordWriter::Options{.folder = folder}, kernel_disk(), before);
    put_scans(220);
    put_end(240);
    writer->close();
    std::ofstream(folder / kContinuesFile) << "/the/first\n";
  }
};

TEST_F(VerifyContinued, SaysWhereTheRestIs) {
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kIncomplete);
  EXPECT_EQ(v.elsewhere, std::vector<std::string>{
                             "what came before is in /the/first; rb recover makes one recording of both"});
  EXPECT_EQ(verdict_text(v), "incomplete, the rest of it is in another folder");
  EXPECT_EQ(v.indexes, std::vector<std::string>{});
  EXPECT_EQ(v.damage, std::vector<std::string>{});
  ASSERT_EQ(v.epoch.size(), 1u);
  EXPECT_EQ(v.epoch[0].samples_deleted, 200);
  EXPECT_EQ(v.epoch[0].samples, 40);
  EXPECT_FALSE(v.epoch[0].is_damaged());
}

TEST_F(VerifyContinued, StillFindsWhatIsMissingBehindItsBeginning) {
  fs::remove(segment_path(folder, 2));
  EXPECT_EQ(verify_record(folder).verdict, Verdict::kDamaged);
}

TEST_F(VerifyContinued, AFirstFolderSaysWhereItGoesOn) {
  fs::remove(folder / kContinuesFile);
  std::ofstream(folder / kContinuedInFile) << "/the/second\n";
  EXPECT_EQ(verify_record(folder).elsewhere,
            std::vector<std::string>{"it goes on in /the/second; rb recover makes one recording of both"});
}

TEST_F(VerifyFinished, ASegmentOfGarbageIsDamage) {
  std::ofstream(segment(3), std::ios::binary) << std::string(5000, 'x');
  EXPECT_EQ(verdict(), Verdict::kDamaged);
}

TEST_F(VerifyFinished, AnEmptySegmentBeforeOthersIsDamage) {
  fs::rename(segment(2), segment(3));
  std::ofstream(segment(2), std::ios::binary);
  fs::remove(folder / "manifest.json");
  EXPECT_EQ(verdict(), Verdict::kDamaged);
}

TEST_F(VerifyFinished, ASegmentNumberThatIsLeftOutIsDamage) {
  fs::rename(segment(2), segment(3));
  fs::remove(folder / "manifest.json");
  EXPECT_EQ(verdict(), Verdict::kDamaged);
}

// One segment's folder could not be synced: nothing in it was promised, and a power cut took its name.
// Another ended at its last sync, and lost the bytes behind.
TEST_F(VerifyFinished, SegmentsGivenUpMayLackWhatWasNeverPromised) {
  const auto write_fourth = [&](std::initializer_list<std::pair<int, std::uint64_t>> given_up) {
    std::ofstream file(segment(4), std::ios::binary);
    for (const auto& [number, end] : given_up) {
      const auto note = encode(Note{
          .kind = NoteKind::kSegmentAbandoned, .a = number, .b = static_cast<std::int64_t>(end), .text = ""});
      const auto header = encode_log_header({.channel = kNoteChannel, .data = note});
      file.write(reinterpret_cast<const char*>(header.data()), std::ssize(header));
      file << kNoteChannel;
      file.write(reinterpret_cast<const char*>(note.data()), std::ssize(note));
    }
  };
  const auto size = fs::file_size(segment(2));
  std::ofstream(segment(2), std::ios::binary | std::ios::app) << std::string(500, 'x');
  fs::remove(folder / "manifest.json");
  write_manifest(folder);
  fs::resize_file(segment(2), size);
  write_fourth({{2, size}, {3, 0}});
  EXPECT_NE(verdict(), Verdict::kDamaged);
  write_fourth({{2, size}});
  EXPECT_EQ(verdict(), Verdict::kDamaged) << "segment 3 is missing";
  write_fourth({{3, 0}});
  EXPECT_EQ(verdict(), Verdict::kDamaged) << "segment 2 is cut";
}

TEST_F(VerifyFinished, AnEmptyLastSegmentIsWhatAKillLeaves) {
  std::ofstream(segment(3), std::ios::binary);
  EXPECT_EQ(verdict(), Verdict::kIncomplete);
  writer.emplace(RecordWriter::Options{.folder = folder});
  EXPECT_EQ(verdict(), Verdict::kComplete);
}

TEST_F(VerifyFinished, ADamagedManifestIsNotTrustedOverTheSegments) {
  for (const char* text : {"", "{", "[]", R"({"segments":7})", R"({"segments":[7,{"file":1,"bytes":2}]})"}) {
    std::ofstream(folder / "manifest.json") << text;
    EXPECT_EQ(verdict(), Verdict::kComplete) << text;
  }
}

TEST_F(VerifyFinished, ARecordOfNothingReadableIsUnreadable) {
  for (const int number : {1, 2}) std::ofstream(segment(number), std::ios::binary) << std::string(3000, 'x');
  EXPECT_EQ(verdict(), Verdict::kUnreadable);
  for (const int number : {1, 2}) std::ofstream(segment(number), std::ios::binary);
  EXPECT_EQ(verdict(), Verdict::kUnreadable);
}

}  // namespace
}  // namespace roadbalance
