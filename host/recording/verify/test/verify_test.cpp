#include "host/recording/verify/verify.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record_writer.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "common/types/crc32c.hpp"
#include "host/recording/verify/test/written_record.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using test::kEpoch;

class Verify : public test::WrittenRecord {};

TEST_F(Verify, CallsARecordWithEverythingComplete) {
  for (int k = 0; k < 10; ++k) put_scans(20 * k);
  put_end(200);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kComplete);
  ASSERT_EQ(v.epoch.size(), 1u);
  EXPECT_EQ(v.epoch[0].blocks, 11);
  EXPECT_EQ(v.epoch[0].samples, 200);
  EXPECT_EQ(v.epoch[0].samples_sent, 200);
}

TEST_F(Verify, CallsADeclaredGapIncomplete) {
  put_scans(0);
  put_gap(20, 100, GapCause::kRingFull);
  put_scans(120);
  put_end(40, 100);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kIncomplete);
  EXPECT_EQ(v.epoch[0].samples_missing, 100);
}

TEST_F(Verify, TakesARecordersGapForTheBlocksGoneAtTheNode) {
  put_scans(0);
  sequence += 4;  // blocks 2 to 5 and the gap's own number 6
  put_gap(20, 100, GapCause::kLostAtNode);
  put_scans(120);
  put_end(140);
  EXPECT_EQ(result().verdict, Verdict::kIncomplete);
}

TEST_F(Verify, TellsWhichBlocksAGapStandsForAndIfTheyHadScans) {
  put_scans(0);
  sequence += 2;  // blocks 2 and 3, and the gap's own number 4: edges
  put_gap(20, 0, GapCause::kLostInRecord);
  put_scans(20);
  sequence += 2;  // blocks 6 and 7, 8: an unknown number of scans
  put_gap(40, 0, GapCause::kLostInRecord);
  put_scans(100);
  put_gap(120, 10, GapCause::kRingFull);
  put_end(60, 70);
  const auto gaps = result().epoch.at(0).gaps;
  ASSERT_EQ(gaps.size(), 3u);
  EXPECT_EQ(gaps[0].first_block, 2);
  EXPECT_EQ(gaps[0].sequence, 4);
  EXPECT_TRUE(gaps[0].has_no_scans);
  EXPECT_EQ(gaps[1].first_block, 6);
  EXPECT_EQ(gaps[1].sequence, 8);
  EXPECT_FALSE(gaps[1].has_no_scans);
  EXPECT_EQ(gaps[2].first_block, gaps[2].sequence) << "the node's own gap stands for no other block";
}

// Each block's own CRC, its number and its scans are good.
TEST_F(Verify, NamesBlocksThatAreNotThoseTheNodeSumsUp) {
  for (int k = 0; k < 10; ++k) put_scans(20 * k);
  sum = BlockSum(sum.crc32c() ^ 1);
  put_end(200);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  ASSERT_EQ(v.epoch.at(0).contradictions.size(), 1u);
  EXPECT_NE(v.epoch[0].contradictions[0].find("the node's sum of its blocks"), std::string::npos);
}

TEST_F(Verify, NothingIsKnownOfTheSumWhereBlocksAreDeclaredLost) {
  put_scans(0);
  put_gap(20, 20, GapCause::kLostAtNode);  // in the place of a block that is nowhere
  sum = BlockSum(1);
  put_end(40);
  EXPECT_EQ(result().verdict, Verdict::kIncomplete);
}

TEST_F(Verify, TheNodesOwnGapsAreInTheSum) {
  put_scans(0);
  put_gap(20, 100, GapCause::kRingFull);
  sum = BlockSum(sum.crc32c() ^ 1);
  put_end(20, 100);
  EXPECT_EQ(result().verdict, Verdict::kDamaged);
}

TEST_F(Verify, CallsAnEpochWithoutAnEndIncomplete) {
  put_scans(0);
  EXPECT_EQ(result().verdict, Verdict::kIncomplete);
}

TEST_F(Verify, FindsABlockThatIsNotThere) {
  put_scans(0);
  ++sequence;
  put_scans(40);
  put_end(60);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  ASSERT_EQ(v.epoch[0].undeclared_blocks.size(), 1u);
  EXPECT_EQ(v.epoch[0].undeclared_blocks[0].first, 2);
  ASSERT_EQ(v.epoch[0].undeclared_scans.size(), 1u);
  EXPECT_EQ(v.epoch[0].undeclared_scans[0].first, 20);
  EXPECT_EQ(v.epoch[0].undeclared_scans[0].last, 39);
}

TEST_F(Verify, FindsScansThatAreNotThereThoughAllBlocksAre) {
  put_scans(0);
  put_scans(40);
  put_end(40);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  EXPECT_TRUE(v.epoch[0].undeclared_blocks.empty());
  EXPECT_EQ(v.epoch[0].undeclared_scans.size(), 1u);
}

TEST_F(Verify, FindsAnEndBeforeTheEndOfTheScans) {
  put_scans(0);
  put_scans(20);
  put(EndBlock{
      .header = header(20, 0), .blocks = sequence, .scans_sealed = 40, .blocks_crc32c = sum.crc32c()});
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  EXPECT_EQ(v.epoch[0].overlapping_blocks, 1);
}

TEST_F(Verify, FindsBlocksBehindTheEndOfTheirEpoch) {
  put_scans(0);
  put_gap(20, 0, GapCause::kNodeCrash);
  put_scans(20);
  put_scans(40);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  ASSERT_EQ(v.epoch[0].contradictions.size(), 1u);
  EXPECT_NE(v.epoch[0].contradictions[0].find("the first is block 3"), std::string::npos);
}

TEST_F(Verify, FindsABlockThatIsThereTwice) {
  put_scans(0);
  --sequence;
  put_scans(0);
  put_end(20);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  EXPECT_EQ(v.epoch[0].repeated_blocks, 1);
}

TEST_F(Verify, FindsTotalsThatDoNotAgree) {
  put_scans(0);
  put_end(21);
  EXPECT_EQ(result().verdict, Verdict::kDamaged);
}

std::streamoff last_commit_bytes() {
  return static_cast<std::streamoff>(28 + std::string_view(kCommitChannel).size() + encode(Commit()).size());
}

// The log's own numbers, stamps and channels count, too.
TEST_F(Verify, FindsAnyAlteredByteBeforeTheLastCommit) {
  put_scans(0);
  put_scans(20);
  put_end(40);
  writer->close();
  const fs::path segment = segment_path(folder, 1);
  std::fstream file(segment, std::ios::binary | std::ios::in | std::ios::out);
  const auto end = static_cast<std::streamoff>(fs::file_size(segment)) - last_commit_bytes();
  for (std::streamoff at = 0; at < end; at += 11) {
    file.seekg(at);
    const char before = static_cast<char>(file.get());
    file.seekp(at);
    file.put(static_cast<char>(before ^ 0x10));
    file.flush();
    const Verification v = verify_record(folder);
    EXPECT_EQ(v.verdict, Verdict::kDamaged) << "byte " << at;
    EXPECT_FALSE(v.damage.empty()) << "byte " << at;
    file.seekp(at);
    file.put(before);
    file.flush();
  }
  EXPECT_EQ(verify_record(folder).verdict, Verdict::kComplete);
}

TEST_F(Verify, ATornTailIsNoDamage) {
  put_scans(0);
  put_scans(20);
  writer->close();
  const fs::path segment = segment_path(folder, 1);
  fs::remove(index_path(folder, 1));  // none is written before a segment is closed
  fs::resize_file(segment, fs::file_size(segment) - static_cast<std::uintmax_t>(last_commit_bytes()) - 10);
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kIncomplete);
  EXPECT_GT(v.torn_bytes, 0u);
  EXPECT_EQ(v.epoch[0].samples, 20);
}

TEST_F(Verify, KnowsThatTheFirstScanIsNumberZero) {
  put_scans(20);
  put_end(20);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  ASSERT_EQ(v.epoch[0].undeclared_scans.size(), 1u);
  EXPECT_EQ(v.epoch[0].undeclared_scans[0].first, 0);
  EXPECT_EQ(v.epoch[0].undeclared_scans[0].last, 19);
}

TEST_F(Verify, SaysInWordsOnlyWhatIsProven) {
  put_scans(0);
  EXPECT_EQ(verdict_text(result()), "incomplete, no end: what came after is unknown");
  writer.emplace(RecordWriter::Options{.folder = folder});
  put_gap(20, 0, GapCause::kNodeCrash);
  EXPECT_EQ(verdict_text(result()), "incomplete, every gap declared");
}

TEST_F(Verify, TellsABlockThatIsThereAgainFromAnotherOneOfItsNumber) {
  put_scans(0);
  --sequence;
  put_scans(0);
  --sequence;
  put_gap(0, 20, GapCause::kRingFull);
  put_end(20);
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  EXPECT_EQ(v.epoch[0].repeated_blocks, 1);
  EXPECT_EQ(v.epoch[0].contradicting_blocks, 1);
}

TEST_F(Verify, ComparesTheJournalWithTheBlocks) {
  const auto entry = [this](std::int64_t first, std::int64_t last, std::int64_t scans,
                            std::uint32_t crc_of_10) {
    Journal journal{.node = 1, .epoch = kEpoch};
    journal.first_sequence = first;
    journal.last_sequence = last;
    journal.first_scan = 20 * (first - 1);
    journal.next_scan = journal.first_scan + scans;
    journal.scans = scans;
    // All counts of these blocks are 0, in every channel alike.
    const std::vector<std::uint8_t> zeros(static_cast<std::size_t>(4 * scans));
    journal.channel_crc.fill(crc32c(zeros));
    journal.channel_crc[10] ^= crc_of_10;
    writer->append(kJournalChannel, encode(journal), 0);
  };
  put_scans(0);
  put_scans(20);
  entry(1, 2, 40, 0);
  put_scans(40);
  entry(3, 3, 20, 0);
  EXPECT_EQ(result().epoch[0].contradictions, std::vector<std::string>{});

  writer.emplace(RecordWriter::Options{.folder = folder});
  put_scans(60);
  entry(4, 4, 20, 1);  // another channel CRC
  put_scans(80);
  entry(5, 6, 40, 0);  // a block more than is here
  const Verification v = result();
  EXPECT_EQ(v.verdict, Verdict::kDamaged);
  EXPECT_EQ(v.journal_entries, 4);
  ASSERT_EQ(v.epoch[0].contradictions.size(), 2u);
  EXPECT_NE(v.epoch[0].contradictions[0].find("the scans here are others"), std::string::npos);
  EXPECT_NE(v.epoch[0].contradictions[1].find("blocks 5 to 6"), std::string::npos);
}

TEST_F(Verify, AnIndexThatSaysSomethingElseIsNamedAndNoDamage) {
  put_scans(0);
  put_end(20);
  writer->close();
  SegmentIndex index = *read_index(folder, 1);
  index.epoch.begin()->second.samples += 1;
  write_index(folder, index);
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kComplete);
  ASSERT_EQ(v.indexes.size(), 1u);
  EXPECT_NE(v.indexes[0].find("seg-000001.idx"), std::string::npos);
}

TEST_F(Verify, CannotReadWhatIsNoRecording) {
  const Verification v = verify_record(folder / "nothing");
  EXPECT_EQ(v.verdict, Verdict::kUnreadable);
  EXPECT_NE(v.error.find("nothing"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
