#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/process/temporary_folder.hpp"
#include "common/record/record_reader.hpp"
#include "common/test/source.hpp"
#include "hil_tests/fuzz/byte_reader.hpp"
#include "hil_tests/fuzz/memory_file.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "host/recording/subset/subset_recording.hpp"
#include "tools/import/import_samples.hpp"

// rb select and rb reduce, any options, over a damaged recording of a drive.
namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using fuzz::require;
using Bytes = std::vector<char>;

constexpr std::size_t kRows = 1200;

fuzz::Reached subsets("a subset");

const VehicleConfig& vehicle() {
  static const VehicleConfig config =
      VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "fuzz");
  return config;
}

/// Counts encode their row and channel, and are not 0, which stands for a channel that was not
/// kept.
constexpr std::int32_t kCountsPerRow = 256;
std::int32_t counts_of(std::int64_t row, std::int32_t node, std::size_t channel) {
  return static_cast<std::int32_t>(row + 1) * kCountsPerRow + node * kChannels +
         static_cast<std::int32_t>(channel);
}

class Drive final : public SampleSource {
 public:
  Drive() {
    for (const NodeConfig& node : vehicle().node)
      for (std::size_t c = 0; c < node.channel.size(); ++c)
        if (node.channel[c].role == ChannelRole::kAcceleration) {
          channel_.push_back({.name = node.channel[c].name, .unit = "m/s^2"});
          place_.push_back({&node, c});
        }
  }
  const std::vector<FileChannel>& channels() const override { return channel_; }
  double part() const override { return 0.0; }
  void rewind() override { row_ = 0; }
  bool read(SampleRows& rows) override {
    rows.clear();
    rows.channels = channel_.size();
    for (; row_ < kRows && rows.rows() < kRowsAtOnce; ++row_) {
      rows.time_s.push_back(static_cast<double>(row_) / vehicle().node.front().rate_hz);
      for (const auto& [node, c] : place_)
        rows.value.push_back(node->channel[c].to_si(counts_of(static_cast<std::int64_t>(row_), node->id, c)));
    }
    return rows.rows() > 0;
  }

 private:
  std::vector<FileChannel> channel_;
  std::vector<std::pair<const NodeConfig*, std::size_t>> place_;  ///< [column]
  std::size_t row_ = 0;
};

/// The one segment of a good recording: two nodes, a wheel that turns, two marks, a gap in time.
const Bytes& good_segment() {
  static const Bytes bytes = [] {
    const TemporaryFolder work("rb-fuzz");
    std::string pulses = "time_s,wheel,kind\n";
    for (int k = 1; k < 250; ++k) pulses += std::to_string(0.0023 * k) + ",front_left,tooth\n";
    const fuzz::MemoryFile samples("drive"), pulse_file(pulses),
        marks("time_s,number,text\n0.1,1,\"begin\"\n0.4,2,\"end\"\n");
    import_samples({.samples = samples.path(),
                    .pulses = pulse_file.path(),
                    .marks = marks.path(),
                    .folder = work.path() / "drive",
                    .open = [](const fs::path&) { return std::make_unique<Drive>(); }},
                   vehicle());
    std::ifstream file(work.path() / "drive" / "seg-000001.lcm", std::ios::binary);
    return Bytes(std::istreambuf_iterator<char>(file), {});
  }();
  return bytes;
}

Bytes damaged(fuzz::ByteReader& in) {
  Bytes bytes = good_segment();
  for (int times = in.byte() % 8; times > 0 && !bytes.empty(); --times) {
    const std::uint8_t what = in.byte();
    const std::size_t at = static_cast<std::size_t>(in.number(3)) % bytes.size();
    const std::size_t size = std::min<std::size_t>(static_cast<std::size_t>(in.number(2)), bytes.size() - at);
    const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const auto end = begin + static_cast<std::ptrdiff_t>(size);
    if (what % 4 == 0) {
      bytes[at] ^= static_cast<char>(1 << (what >> 2 & 7));
    } else if (what % 4 == 1) {
      bytes.resize(at);
    } else if (what % 4 == 2) {
      bytes.erase(begin, end);
    } else {
      const Bytes twice(begin, end);
      bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(in.number(3) % bytes.size()), twice.begin(),
                   twice.end());
    }
  }
  return bytes;
}

/// Mostly none or good ones, so that there is something to be made.
std::vector<std::string> names(fuzz::ByteReader& in) {
  static const std::vector<std::string> good{"front", "rear", vehicle().node.front().channel.front().name};
  static const std::vector<std::string> bad{"front_left", "", "no such", "a,b"};
  constexpr int kBad = 240;
  std::vector<std::string> chosen;
  for (int k = in.byte() % 4; k > 1; --k) {
    const int what = in.byte();
    const auto& all = what < kBad ? good : bad;
    chosen.push_back(all[static_cast<std::size_t>(what) % all.size()]);
  }
  return chosen;
}

double number(fuzz::ByteReader& in) {
  const std::uint8_t what = in.byte();
  if (what < 8) return std::array{1e308, -1e308, 1e18, -1e18, 9.3e9, 0.0, -0.0, 1e-300}[what];
  return (static_cast<double>(in.number(2)) - 8000.0) * 1e-4;
}

SubsetRequest request(fuzz::ByteReader& in) {
  SubsetRequest request;
  const std::uint8_t what = in.byte();
  if (what & 1) request.time.from_s = number(in);
  if (what & 2) request.time.to_s = number(in);
  if (what & 4) request.time.from_mark = in.below(4);
  if (what & 8) request.time.to_mark = in.below(4);
  if (what & 16) request.time.least_m_s = number(in);
  if (what & 32) request.time.most_m_s = number(in);
  request.time.clean = (what & 64) != 0;
  request.time.least_s = 0.001 * static_cast<double>(in.byte());
  if (what & 128) request.factor = 1 + static_cast<int>(in.byte() % 12);
  request.choice.nodes = names(in);
  request.choice.channels = names(in);
  return request;
}

std::int64_t samples_of(const Verification& verification) {
  std::int64_t samples = 0;
  for (const VerifiedEpoch& epoch : verification.epoch) samples += epoch.samples;
  return samples;
}

/// The row of the drive that a made one came from, by all its kept columns.
std::int64_t row_of(const std::array<std::int32_t, kChannels>& counts, const NodeConfig& node,
                    bool keeps_all) {
  std::optional<std::int64_t> row;
  for (std::size_t c = 0; c < node.channel.size(); ++c) {
    if (node.channel[c].role != ChannelRole::kAcceleration) continue;
    if (counts[c] == 0 && !keeps_all) continue;
    if (!row) row = counts[c] / kCountsPerRow - 1;
    require(counts[c] == counts_of(*row, node.id, c), "a sample is of its channel, and all of a row of one");
  }
  require(row && *row >= 0 && *row < static_cast<std::int64_t>(kRows), "a row is one of the drive");
  return *row;
}

/// Check of a subset that leaves every kept sample as it was.
void check_rows(const SubsetRequest& asked) {
  std::map<std::pair<std::int32_t, std::int64_t>, std::int64_t> offset;  // of rows to scans, by epoch
  RecordReader reader(asked.output);
  reader.finish();
  SealedBlock block;
  while (const auto event = reader.next()) {
    if (accept(event->data, block) != Refusal::kNone || block.kind != BlockKind::kScan) continue;
    const ScanBlock scans = decode_scan(block);
    const NodeConfig* node = vehicle().node_with_id(scans.header.node);
    require(node != nullptr, "a sample is of a node of the drive");
    for (std::int64_t k = 0; k < scans.header.scans; ++k) {
      const std::int64_t off =
          row_of(scans.counts[static_cast<std::size_t>(k)], *node, asked.choice.channels.empty()) -
          (scans.header.first_scan + k);
      const auto first = offset.try_emplace({scans.header.node, scans.header.epoch}, off).first;
      require(first->second == off, "rows stand in their order, and as far apart as they were");
    }
  }
}

void check(std::span<const std::uint8_t> bytes) {
  fuzz::ByteReader in(bytes);
  SubsetRequest asked = request(in);
  const Bytes original = damaged(in);
  static const TemporaryFolder work("rb-fuzz-subset");
  asked.folder = work.path() / "drive";
  asked.output = work.path() / "part";
  fs::remove_all(asked.output);
  fs::create_directories(asked.folder);
  const fs::path segment = asked.folder / "seg-000001.lcm";
  std::ofstream(segment, std::ios::binary | std::ios::trunc)
      .write(original.data(), static_cast<std::streamsize>(original.size()));
  try {
    const SubsetReport report = subset_recording(asked);
    require(fs::exists(asked.output), "what is done is there");
    const Verification& made = report.verification;
    require(made.verdict == Verdict::kComplete || made.verdict == Verdict::kIncomplete,
            "what is made is good");
    const auto all = static_cast<std::int64_t>(kRows * vehicle().node.size());
    require(samples_of(made) > 0 && samples_of(made) <= all / asked.factor + 64, "no sample is made up");
    if (asked.factor == 1) check_rows(asked);
    subsets.count();
  } catch (const std::runtime_error& error) {
    require(error.what()[0] != 0, "a refusal says why");
    require(!fs::exists(asked.output), "what is refused leaves nothing");
  }
  require(!fs::exists(asked.output.string() + ".part"), "nothing half made is left");
  std::ifstream file(segment, std::ios::binary);
  require(Bytes(std::istreambuf_iterator<char>(file), {}) == original, "the original stays as it is");
}

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  roadbalance::check({data, size});
  return 0;
}
