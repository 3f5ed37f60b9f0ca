#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <sstream>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record.hpp"
#include "common/test/bus_url.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "hil_tests/program.hpp"

namespace roadbalance {
namespace {

constexpr int kBlocks = 200;
constexpr double kPatience_s = 60;

ScanBlock block(int k) {
  ScanBlock scans;
  scans.header = {.node = 4,
                  .epoch = -12345,
                  .sequence = k + 1,
                  .first_scan = 20 * k,
                  .scans = 20,
                  .time_ns = 10'000'000 * k};
  scans.period_ps = 500'000'000;
  for (int scan = 0; scan < kScansPerBlock; ++scan)
    for (int channel = 0; channel < kChannels; ++channel)
      scans.counts[static_cast<std::size_t>(scan)][static_cast<std::size_t>(channel)] =
          1000 * k + 16 * scan - 3 * channel;
  scans.quality = kQualityAfterGap;
  return scans;
}

void record_blocks(const std::filesystem::path& folder) {
  RecordWriter writer({.folder = folder});
  SealedBlock sealed;
  for (int k = 0; k < kBlocks; ++k) {
    seal(block(k), sealed);
    writer.append(block_channel(4, BlockKind::kScan), sealed.bytes(), 1'000'000 + 100 * k);
  }
  writer.close();
}

TEST(StockLcm, LogPlayerReplaysASegmentOnTheBusUnchanged) {
  const test::TemporaryDirectory folder;
  record_blocks(folder.path());
  const std::string url = test::bus_url();
  Bus bus(url);
  std::vector<SealedBlock> received;
  bus.subscribe("RB_BLOCK_4_SCAN", [&](std::string_view, std::span<const std::uint8_t> bytes) {
    SealedBlock accepted;
    if (accept(bytes, accepted) == Refusal::kNone) received.push_back(accepted);
  });
  test::Program player("lcm-logplayer", {"--lcm-url=" + url, folder.path() / "seg-000001.lcm"});
  ASSERT_TRUE(test::wait_until(
      [&] {
        bus.handle(std::chrono::milliseconds(10));
        return received.size() >= kBlocks;
      },
      kPatience_s))
      << received.size() << " of " << kBlocks << " blocks came";
  ASSERT_EQ(player.exit_code(kPatience_s), 0);
  ASSERT_EQ(received.size(), static_cast<std::size_t>(kBlocks));
  for (int k = 0; k < kBlocks; ++k) {
    SealedBlock sealed;
    seal(block(k), sealed);
    ASSERT_TRUE(std::ranges::equal(received[static_cast<std::size_t>(k)].bytes(), sealed.bytes()))
        << "block " << k;
  }
}

// lcm-spy decodes with classes that lcm-gen makes for Java and LCM's Java library: nothing of our codec.
TEST(StockLcm, TheDecoderOfLcmSpyUnderstandsARecordedBlock) {
  const std::filesystem::path jar = "/usr/share/java/lcm.jar";
  ASSERT_TRUE(std::filesystem::exists(jar)) << "liblcm-java is missing: run tools/setup";
  const test::TemporaryDirectory folder;
  record_blocks(folder.path() / "record");
  const auto types = folder.path() / "types";
  ASSERT_EQ(test::run("lcm-gen", {"-j", "--jpath", types, test::source_path("common/wire/scan_block_t.lcm")},
                      kPatience_s),
            0);
  ASSERT_EQ(
      test::run("javac",
                {"-nowarn", "-cp", jar.string() + ":" + types.string(), "-d", types,
                 test::source_path("hil_tests/java/PrintBlocks.java"), types / "wire/scan_block_t.java"},
                kPatience_s),
      0)
      << "default-jdk-headless is missing? run tools/setup";
  const auto printed = folder.path() / "printed";
  ASSERT_EQ(test::run("java",
                      {"-cp", jar.string() + ":" + types.string(), "PrintBlocks",
                       folder.path() / "record/seg-000001.lcm", printed},
                      kPatience_s),
            0);

  std::ostringstream expected;
  for (int k = 0; k < kBlocks; ++k) {
    const ScanBlock b = block(k);
    expected << b.header.node << ' ' << b.header.epoch << ' ' << b.header.sequence << ' '
             << b.header.first_scan << ' ' << b.header.scans << ' ' << b.header.time_ns << ' ' << b.period_ps
             << ' ' << b.counts[0][0] << ' ' << b.counts[19][15] << ' ' << b.quality << '\n';
  }
  std::stringstream got;
  got << std::ifstream(printed).rdbuf();
  EXPECT_EQ(got.str(), expected.str());
}

}  // namespace
}  // namespace roadbalance
