#include "host/recorder/verify.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <optional>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;
constexpr std::int64_t kEpoch = 42;

class Verify : public ::testing::Test {
 protected:
  Verify()
      : folder(fs::temp_directory_path() /
               ("rb-verify-" + std::to_string(::getpid()) + "-" +
                ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(folder);
    writer.emplace(RecordWriter::Options{.folder = folder});
  }
  ~Verify() override { fs::remove_all(folder); }

  BlockHeader header(std::int64_t first_scan, std::int64_t scans) {
    return {.node = 1,
            .epoch = kEpoch,
            .sequence = ++sequence,
            .first_scan = first_scan,
            .scans = scans,
            .time_ns = 0};
  }
  template <typename Block>
  void put(const Block& block) {
    SealedBlock sealed;
    seal(block, sealed);
    writer->append(block_channel(1, sealed.kind), sealed.bytes(), 0);
  }
  void put_scans(std::int64_t first_scan) {
    ScanBlock block;
    block.header = header(first_scan, 20);
    block.period_ps = 1;
    put(block);
  }
  void put_gap(std::int64_t first_scan, std::int64_t scans, GapCause cause) {
    put(GapBlock{.header = header(first_scan, scans), .cause = cause});
  }
  void put_end(std::int64_t scans, std::int64_t missing = 0) {
    put(EndBlock{.header = header(scans + missing, 0),
                 .blocks = sequence,
                 .scans_sealed = scans,
                 .scans_missing = missing});
  }
  Verification result() {
    writer->close();
    return verify_record(folder);
  }

  const fs::path folder;
  std::optional<RecordWriter> writer;
  std::int64_t sequence = 0;
};

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

TEST_F(Verify, FindsAnyAlteredByteOfABlock) {
  put_scans(0);
  put_scans(20);
  put_end(40);
  writer->close();
  const fs::path segment = segment_path(folder, 1);
  std::fstream file(segment, std::ios::binary | std::ios::in | std::ios::out);
  for (std::streamoff at = 60; at < static_cast<std::streamoff>(fs::file_size(segment)); at += 61) {
    file.seekg(at);
    const char before = static_cast<char>(file.get());
    file.seekp(at);
    file.put(static_cast<char>(before ^ 0x10));
    file.flush();
    const Verdict verdict = verify_record(folder).verdict;
    // Numbers and time stamps of the log itself are no data; they are the 16 bytes behind each sync word.
    const std::streamoff event_bytes = 28 + 15 + 1352;
    const bool is_stamp = at % event_bytes >= 4 && at % event_bytes < 20;
    EXPECT_TRUE(is_stamp || verdict == Verdict::kDamaged || verdict == Verdict::kIncomplete) << "byte " << at;
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
  fs::resize_file(segment, fs::file_size(segment) - 10);
  const Verification v = verify_record(folder);
  EXPECT_EQ(v.verdict, Verdict::kIncomplete);
  EXPECT_GT(v.torn_bytes, 0u);
  EXPECT_EQ(v.epoch[0].samples, 20);
}

TEST_F(Verify, CannotReadWhatIsNoRecording) {
  const Verification v = verify_record(folder / "nothing");
  EXPECT_EQ(v.verdict, Verdict::kUnreadable);
  EXPECT_NE(v.error.find("nothing"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
