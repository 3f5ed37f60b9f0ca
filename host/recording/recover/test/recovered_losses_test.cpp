// Losses that no gap can stand for: the new record declares them, and is not complete.
#include "host/recording/recover/recovered_losses.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record_writer.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "common/record/test/simulated_disk.hpp"
#include "host/recording/recover/recover.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {
namespace {

using Lines = std::vector<std::string>;

class RecoveredLossesTest : public ::testing::Test {
 protected:
  void begin(const char* folder = "/old") { writer.emplace(RecordWriter::Options{.folder = folder}, disk); }
  void put(NoteKind kind, std::int64_t a) {
    writer->append(kNoteChannel, encode(Note{.kind = kind, .a = a, .text = "pothole"}), 0);
  }
  // A whole epoch in which nothing was measured.
  void put_epoch(std::int32_t node) {
    SealedBlock end;
    seal(EndBlock{.header = {.node = node, .epoch = 7, .sequence = 1}, .blocks = 1}, end);
    writer->append(end, 0);
  }
  void write() {
    begin();
    put_epoch(1);
    put(NoteKind::kMark, 1);
    put_epoch(2);
    put(NoteKind::kMark, 2);
    put_epoch(3);
    writer->close();
    ASSERT_EQ(verify_record("/old", disk).verdict, Verdict::kComplete);
  }

  using Change = std::function<void(std::vector<std::uint8_t>& bytes, std::size_t offset, std::size_t size)>;
  /// Place of the event with this number, from 0 on.
  void change(int which, const Change& change) {
    RecordReader reader("/old", disk);
    std::optional<LogEvent> event;
    for (int at = 0; at <= which; ++at) event = reader.next();
    auto bytes = disk.content("/old/seg-000001.lcm");
    change(bytes, reader.offset(), 28 + event->channel.size() + event->data.size());
    disk.put("/old/seg-000001.lcm", bytes);
  }
  static void zero(std::vector<std::uint8_t>& bytes, std::size_t offset, std::size_t size) {
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), size, std::uint8_t{0});
  }
  static void flip_in_data(std::vector<std::uint8_t>& bytes, std::size_t offset, std::size_t size) {
    bytes[offset + size - 10] ^= 4;
  }

  void tear() {
    disk.unlink(index_path("/old", 1).c_str());
    auto bytes = disk.content("/old/seg-000001.lcm");
    bytes.insert(bytes.end(), 500, 'x');
    disk.put("/old/seg-000001.lcm", bytes);
  }

  // The declaration of a recovered record is kept by one that is recovered from it.
  Lines declared() {
    const Recovered recovered = recover({"/old"}, "/new", disk);
    const Verification result = verify_record("/new", disk);
    EXPECT_EQ(result.verdict, recovered.lost.empty() ? Verdict::kComplete : Verdict::kIncomplete);
    EXPECT_EQ(result.lost.size(), recovered.lost.size());
    for (std::size_t k = 0; k < std::min(result.lost.size(), recovered.lost.size()); ++k)
      EXPECT_TRUE(result.lost[k].ends_with(recovered.lost[k])) << result.lost[k];
    EXPECT_TRUE(recover({"/new"}, "/again", disk).lost.empty()) << "nothing is lost by it";
    EXPECT_EQ(verify_record("/again", disk).lost, result.lost);
    return recovered.lost;
  }

  test::SimulatedDisk disk;
  std::optional<RecordWriter> writer;
};

TEST_F(RecoveredLossesTest, NothingIsDeclaredOfAWholeRecord) {
  write();
  EXPECT_EQ(declared(), Lines{});
}

TEST_F(RecoveredLossesTest, AWholeEpochThatIsGoneIsDeclared) {
  write();
  change(2, zero);
  const Lines lost = declared();
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_NE(lost[0].find(" bytes that are no events"), std::string::npos) << lost[0];
}

TEST_F(RecoveredLossesTest, AMarkThatIsGoneOrAlteredIsDeclared) {
  write();
  change(1, flip_in_data);
  change(3, zero);
  const Lines lost = declared();
  ASSERT_EQ(lost.size(), 2u);
  EXPECT_NE(lost[0].find(" bytes that are no events"), std::string::npos) << lost[0];
  EXPECT_EQ(lost[1], "1 altered entries: notes, clocks, journal or commits");
}

// The note is good, but on a channel that is not read.
TEST_F(RecoveredLossesTest, AnAlteredChannelIsDeclared) {
  write();
  change(1, [](auto& bytes, std::size_t offset, std::size_t) { bytes[offset + 28 + 6] ^= 1; });
  EXPECT_EQ(declared(), Lines{"1 stretches of events of which one is altered: number, stamp or channel, or contents with their CRC"});
}

// Numbers prove the missing blocks of an epoch that is here.
TEST_F(RecoveredLossesTest, AnAlteredBlockIsDeclaredIfNoOtherOfItsEpochIsThere) {
  write();
  change(0, flip_in_data);
  EXPECT_EQ(declared(), Lines{"1 altered blocks, of epochs of which no other is there"});
  begin("/spool");
  put_epoch(1);
  writer->close();
  const Recovered filled = recover({"/old", "/spool"}, "/filled", disk);
  EXPECT_EQ(filled.blocks_altered, 1);
  EXPECT_EQ(filled.lost, Lines{});
  EXPECT_EQ(verify_record("/filled", disk).verdict, Verdict::kComplete);
}

TEST_F(RecoveredLossesTest, WhatAKillLeavesAtTheEndIsNoLoss) {
  write();
  tear();
  EXPECT_EQ(declared(), Lines{});
}

TEST_F(RecoveredLossesTest, NorIsWhatARecorderThatWentOnHasCut) {
  write();
  tear();
  begin();
  put_epoch(4);
  writer->close();
  EXPECT_EQ(declared(), Lines{});
}

TEST_F(RecoveredLossesTest, DeletedSegmentsAreDeclared) {
  write();
  begin();
  put(NoteKind::kSegmentDeleted, 1);
  put_epoch(4);
  writer->close();
  begin();
  put_epoch(5);
  writer->close();
  delete_segment("/old", 1, disk);
  const Lines deleted{"segment 1 of old, which the retention mode had deleted"};
  EXPECT_EQ(declared(), deleted);
  EXPECT_EQ(recover({"/old/"}, "/named with a slash", disk).lost, deleted);
}

class RecoverOfTwoFoldersTest : public RecoveredLossesTest {
 protected:
  // Wherever the disks were mounted when it was recorded.
  void write_two(const std::string& first = "/car/first", const std::string& second = "/car/second") {
    write();
    write_line("/old", kContinuedInFile, second);
    begin("/second");
    put_epoch(4);
    writer->close();
    write_line("/second", kContinuesFile, first);
  }
  void write_line(const std::string& folder, const std::string& file, const std::string& other) {
    const std::string line = other + "\n";
    disk.put(folder + "/" + file, {line.begin(), line.end()});
  }
  Lines lost_of(const std::vector<std::filesystem::path>& folders) {
    const std::string target = "/new" + std::to_string(++targets_);
    const Lines lost = recover(folders, target, disk).lost;
    EXPECT_EQ(verify_record(target, disk).verdict, lost.empty() ? Verdict::kComplete : Verdict::kIncomplete);
    return lost;
  }

 private:
  int targets_ = 0;
};

TEST_F(RecoverOfTwoFoldersTest, EitherAloneNamesTheOther) {
  write_two();
  EXPECT_EQ(lost_of({"/old"}), Lines{"it goes on in /car/second"});
  EXPECT_EQ(lost_of({"/old", "/old/"}), Lines{"it goes on in /car/second"}) << "twice the same is no other";
  EXPECT_EQ(lost_of({"/second"}), Lines{"what came before is in /car/first"});
}

TEST_F(RecoverOfTwoFoldersTest, AnotherFolderIsNotThatOne) {
  write_two();
  begin("/spool");
  put_epoch(1);
  writer->close();
  EXPECT_EQ(lost_of({"/old", "/spool"}), Lines{"it goes on in /car/second"});
}

TEST_F(RecoverOfTwoFoldersTest, BothAreWholeIfTheFirstHasItsNameStill) {
  write_two("/car/old", "/car/renamed");
  EXPECT_EQ(lost_of({"/old", "/second"}), Lines{});
}

TEST_F(RecoverOfTwoFoldersTest, BothAreWholeIfTheSecondHasItsNameStill) {
  write_two("/car/renamed", "/car/second");
  EXPECT_EQ(lost_of({"/old", "/second"}), Lines{});
}

// A failed disk takes no file with the place of the rest.
TEST_F(RecoverOfTwoFoldersTest, TheFirstOneNeedNotKnowOfTheSecond) {
  write_two("/car/old");
  disk.unlink("/old/continued-in");
  EXPECT_EQ(lost_of({"/old", "/second"}), Lines{});
}

// Two recorders with one fallback.
TEST_F(RecoverOfTwoFoldersTest, EachFolderThatGoesOnThereIsWanted) {
  write_two("/car/old\n/car/other");
  EXPECT_EQ(lost_of({"/old", "/second"}), Lines{"what came before is in /car/other"});
}

}  // namespace
}  // namespace roadbalance
