#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/compensation.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/display.hpp"
#include "common/bus/job.hpp"
#include "common/bus/notes.hpp"
#include "common/bus/operation.hpp"
#include "common/bus/order_report.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/bus/recording.hpp"
#include "common/bus/remark.hpp"
#include "common/bus/results.hpp"
#include "common/bus/setup.hpp"
#include "common/bus/tap.hpp"
#include "common/bus/transfer_function_report.hpp"
#include "common/bus/weight_check.hpp"
#include "common/record/record_writer.hpp"
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

/// The classes that lcm-spy decodes with, made by lcm-gen for LCM's Java library: nothing of our codec.
class JavaDecoder {
 public:
  /// @param program  class of hil_tests/java
  JavaDecoder(const std::string& program, const std::vector<std::string>& types,
              const std::filesystem::path& folder)
      : program_(program), classes_(folder / "classes") {
    EXPECT_TRUE(std::filesystem::exists(kJar)) << "liblcm-java is missing: run tools/setup";
    std::vector<std::string> generate{"-j", "--jpath", classes_};
    std::vector<std::string> compile{
        "-nowarn", "-cp", path(), "-d", classes_, test::source_path("hil_tests/java/" + program + ".java")};
    for (const auto& type : types) {
      generate.push_back(test::source_path("common/wire/" + type + ".lcm"));
      compile.push_back(classes_ / "wire" / (type + ".java"));
    }
    EXPECT_EQ(test::run("lcm-gen", generate, kPatience_s), 0);
    EXPECT_EQ(test::run("javac", compile, kPatience_s), 0)
        << "default-jdk-headless is missing? run tools/setup";
  }

  /// Output of the program for a segment.
  std::string run(const std::filesystem::path& segment, const std::vector<std::string>& more = {}) const {
    const auto output = classes_ / "output";
    std::vector<std::string> arguments{"-cp", path(), program_, segment, output};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(test::run("java", arguments, kPatience_s), 0);
    std::stringstream text;
    text << std::ifstream(output).rdbuf();
    return text.str();
  }

 private:
  static constexpr const char* kJar = "/usr/share/java/lcm.jar";
  std::string path() const { return kJar + (":" + classes_.string()); }

  std::string program_;
  std::filesystem::path classes_;
};

TEST(StockLcm, TheDecoderOfLcmSpyUnderstandsARecordedBlock) {
  const test::TemporaryDirectory folder;
  record_blocks(folder.path() / "record");
  const JavaDecoder decoder("PrintBlocks", {"scan_block_t"}, folder.path());
  std::ostringstream expected;
  for (int k = 0; k < kBlocks; ++k) {
    const ScanBlock b = block(k);
    expected << b.header.node << ' ' << b.header.epoch << ' ' << b.header.sequence << ' '
             << b.header.first_scan << ' ' << b.header.scans << ' ' << b.header.time_ns << ' ' << b.period_ps
             << ' ' << b.counts[0][0] << ' ' << b.counts[19][15] << ' ' << b.quality << '\n';
  }
  EXPECT_EQ(decoder.run(folder.path() / "record/seg-000001.lcm"), expected.str());
}

TEST(StockLcm, TheDecoderOfLcmSpyUnderstandsEveryMessage) {
  const test::TemporaryDirectory folder;
  std::vector<std::string> types;  // in the order of the events
  {
    RecordWriter writer({.folder = folder.path() / "record"});
    const auto append = [&](const std::string& type, std::span<const std::uint8_t> bytes) {
      writer.append("ANY", bytes, 1'000'000);
      types.push_back(type);
    };
    SealedBlock sealed;
    const auto append_block = [&](const std::string& type, const auto& message) {
      seal(message, sealed);
      append(type, sealed.bytes());
    };
    const BlockHeader header{
        .node = 4, .epoch = 77, .sequence = 3, .first_scan = 40, .scans = 0, .time_ns = 5};
    append_block("scan_block_t", block(0));
    EdgeBlock edges;
    edges.header = header;
    edges.add({.time = node_time_from_ns(5), .line = 1, .kind = EdgeKind::kZeroMark});
    append_block("edge_block_t", edges);
    SignalBlock signals;
    for (int k = 0; k < kSamplesPerBlock; ++k)
      EXPECT_TRUE(signals.add({node_time_from_ns(5 + k), static_cast<std::uint16_t>(4 * k), -0.3 * k}));
    signals.header = header;
    append_block("signal_block_t", signals);
    append_block("gap_t", GapBlock{.header = header, .cause = GapCause::kRingFull});
    append_block("meta_t", MetaBlock{.header = header, .text = "name = \"car\""});
    append_block("end_t", EndBlock{.header = header, .blocks = 3, .scans_sealed = 40});
    append("heartbeat_t", encode(Heartbeat{.node = 4, .epoch = 77}));
    append("ack_t", encode(Ack{.node = 4, .epoch = 77, .missing = {{2, 3}}}));
    append("command_t", encode(Command{.node = 4, .request = 9}));
    append("reply_t", encode(Reply{.node = 4, .epoch = 77}));
    append("level_t", encode(Level{.node = 4, .speed_m_s = 33.0}));
    append("spectrum_t", encode(SpectrumPart{.node = 4, .density = {1.0F, 2.0F}}));
    append("identification_t", encode(Identification{.speed_class = {{25.0, 70.0}}}));
    append("balance_t", encode(Balance{.wheel = 2, .unbalance_g = 35.0}));
    append("compensation_t", encode(Compensation{.wheel = 2}));
    append("journal_t", encode(Journal{.node = 4, .epoch = 77}));
    append("note_t", encode(Note{.kind = NoteKind::kStarted, .text = "text"}));
    append("commit_t", encode(Commit{.bytes = 4096}));
    append("clock_exchange_t", encode(ClockExchange{.node = 4, .epoch = 77}));
    append("clock_fit_t", encode(ClockFit{.node = 4, .epoch = 77, .drift = 2e-5}));
    append("recorder_t", encode(RecorderStatus{.segment = 2}));
    append("orders_t", encode(OrderReport{.wheel = 2, .node = 4}));
    append("view_t", encode(View{.viewer = 1, .pair = {{{4, 2}, {4, 3}}}}));
    append("transfer_t",
           encode(TransferFunctionPart{.viewer = 1, .bin = {{1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 0.5F}}}));
    append("envelope_t", encode(Envelope{.node = 4, .channel = 2, .bucket = {{-1.0F, 2.0F}}}));
    append("waterfall_t", encode(WaterfallRow{.of = {2, {4, 1}}, .blocks = 3, .amplitude = {0.5F, 2.0F}}));
    append("request_t", encode(Request{.asker = 1, .request = 2, .node = 4, .text = "bridge"}));
    append("answer_t", encode(Answer{.asker = 1, .request = 2, .value = {0.5, -2.0}, .text = "mark 1"}));
    append("receipt_t", encode(Receipt{.nodes = 1, .node = 4, .overload_s = 0.25, .name = "drive"}));
    append("vehicle_t", encode(VehiclePart{.node = 4, .incarnation = 1, .parts = 1, .text = "name = 1"}));
    append("remark_t", encode(Remark{.remarks = 1, .text = "text"}));
    append("knock_t", encode(Tap{.node = 4, .channel = 2}));
    NodeSetup setup;
    setup.node = 4;
    setup.name = "front";
    append("setup_t", encode(setup));
    append("verification_t", encode(WeightCheck{.wheel = 2}));
    append("recording_t", encode(RecordingSummary{}));
    append("job_t", encode(Job{.jobs = 1, .recording = "drive", .progress = 0.5, .text = "text"}));
    append("document_t", encode(DocumentPart{.parts = 1, .bytes = "text"}));
    writer.close();
  }
  const auto all = std::filesystem::directory_iterator(test::source_path("common/wire"));
  EXPECT_EQ(
      std::count_if(begin(all), end(all), [](const auto& file) { return file.path().extension() == ".lcm"; }),
      static_cast<std::ptrdiff_t>(types.size()))
      << "a message type is not in this test";

  const JavaDecoder decoder("DecodeEvents", types, folder.path());
  std::string expected;
  for (const auto& type : types) expected += type + " true\n";
  expected += "commit_t true\n";  // which closes the segment
  EXPECT_EQ(decoder.run(folder.path() / "record/seg-000001.lcm", types), expected);
}

}  // namespace
}  // namespace roadbalance
