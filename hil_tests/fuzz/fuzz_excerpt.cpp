#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/process/temporary_folder.hpp"
#include "common/test/source.hpp"
#include "hil_tests/fuzz/byte_reader.hpp"
#include "hil_tests/fuzz/memory_file.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "host/excerpt/excerpt_recording.hpp"
#include "tools/rb/import_samples.hpp"

// rb select and rb reduce, any options, over a damaged recording of a drive.
namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using fuzz::require;
using Bytes = std::vector<char>;

constexpr std::size_t kRows = 1200;

fuzz::Reached excerpts("an excerpt");

const VehicleConfig& vehicle() {
  static const VehicleConfig config =
      VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "fuzz");
  return config;
}

class Drive final : public SampleSource {
 public:
  Drive() {
    for (const NodeConfig& node : vehicle().node)
      for (const ChannelConfig& channel : node.channel)
        if (channel.role == ChannelRole::kAcceleration) name_.push_back(channel.name);
  }
  const std::vector<std::string>& names() const override { return name_; }
  double part() const override { return 0.0; }
  void rewind() override { row_ = 0; }
  bool read(SampleRows& rows) override {
    rows.clear();
    rows.channels = name_.size();
    for (; row_ < kRows && rows.rows() < kRowsAtOnce; ++row_) {
      rows.time_s.push_back(static_cast<double>(row_) / vehicle().node.front().rate_hz);
      rows.value_si.insert(rows.value_si.end(), name_.size(), std::sin(100.0 * rows.time_s.back()));
    }
    return rows.rows() > 0;
  }

 private:
  std::vector<std::string> name_;
  std::size_t row_ = 0;
};

/// The one segment of a good recording: two nodes, a wheel that turns, two marks, a gap in time.
const Bytes& good_segment() {
  static const Bytes bytes = [] {
    const TemporaryFolder work("rb-fuzz");
    std::string pulses = "time_s,wheel,kind\n";
    for (int k = 1; k < 250; ++k) pulses += std::to_string(0.0023 * k) + ",front_left,tooth\n";
    const fuzz::MemoryFile pulse_file(pulses), marks("time_s,number,text\n0.1,1,\"begin\"\n0.4,2,\"end\"\n");
    import_samples({.samples = "drive",
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

ExcerptRequest request(fuzz::ByteReader& in) {
  ExcerptRequest request;
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

void check(std::span<const std::uint8_t> bytes) {
  fuzz::ByteReader in(bytes);
  ExcerptRequest asked = request(in);
  const Bytes original = damaged(in);
  static const TemporaryFolder work("rb-fuzz-excerpt");
  asked.folder = work.path() / "drive";
  asked.output = work.path() / "part";
  fs::remove_all(asked.output);
  fs::create_directories(asked.folder);
  const fs::path segment = asked.folder / "seg-000001.lcm";
  std::ofstream(segment, std::ios::binary | std::ios::trunc)
      .write(original.data(), static_cast<std::streamsize>(original.size()));
  try {
    const ExcerptReport report = excerpt_recording(asked);
    require(fs::exists(asked.output), "what is done is there");
    const Verification& made = report.verification;
    require(made.verdict == Verdict::kComplete || made.verdict == Verdict::kIncomplete,
            "what is made is good");
    const auto all = static_cast<std::int64_t>(kRows * vehicle().node.size());
    require(samples_of(made) > 0 && samples_of(made) <= all / asked.factor + 64, "no sample is made up");
    excerpts.count();
  } catch (const std::exception& error) {
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
