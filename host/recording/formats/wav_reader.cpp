#include "host/recording/formats/wav_reader.hpp"

#include <sndfile.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/config/section.hpp"
#include "common/record/file.hpp"
#include "host/recording/formats/line_reader.hpp"
#include "host/recording/formats/wav_chunks.hpp"
#include "host/recording/formats/wav_scale.hpp"

namespace roadbalance {
namespace {

constexpr double kMostScale = 1e100;  ///< so that every sample is a number

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& reason) {
  throw ConfigError(file.string() + ": " + reason);
}

struct Description {
  double rate_hz = 0.0, first_s = 0.0;
  std::int64_t rows = 0;
  struct Channel {
    std::string name, unit;
    double scale, offset_counts;
  };
  double time_s(std::int64_t row) const { return first_s + static_cast<double>(row) / rate_hz; }
  std::vector<Channel> channel;
};

/// As description_json() wrote it.
Description describe(const std::filesystem::path& file, const std::optional<WavComment>& comment,
                     int channels) {
  if (!comment) fail(file, "has no comment that tells its channels and scales; allowed: a file of rb export");
  try {
    const nlohmann::json json = nlohmann::json::parse(comment->text);
    const nlohmann::json& group = json.at("groups").at(0);
    Description found{group.at("rate_hz").get<double>(),
                      group.at("first_s").get<double>(),
                      group.at("rows").get<std::int64_t>(),
                      {}};
    std::set<std::string> seen;
    for (const nlohmann::json& channel : group.at("channels")) {
      found.channel.push_back({channel.at("name").get<std::string>(), channel.at("unit").get<std::string>(),
                               channel.at("scale").get<double>(), channel.at("offset_counts").get<double>()});
      const Description::Channel& last = found.channel.back();
      if (!seen.insert(last.name).second) fail(file, "channel " + last.name + " stands twice in its comment");
      if (std::abs(last.scale) > kMostScale || std::abs(last.offset_counts) > kMostScale)
        fail(file, "channel " + last.name + ": scale or offset_counts in its comment is beyond 1e100");
    }
    if (std::ssize(found.channel) != channels)
      fail(file, std::to_string(channels) + " channels, but its comment tells " +
                     std::to_string(found.channel.size()));
    if (!(found.rate_hz > 0.0)) fail(file, "rate_hz in its comment is not above 0");
    if (!is_countable(found.first_s) || !is_countable(found.time_s(found.rows)))
      fail(file, std::string("the time of its samples, as its comment tells it, ") + kTooFarOff);
    return found;
  } catch (const nlohmann::json::exception& error) {
    fail(file, "its comment, from byte " + std::to_string(comment->at) +
                   ", is not that of rb export: " + error.what());
  }
}

class WavSamples final : public SampleSource {
 public:
  explicit WavSamples(std::filesystem::path path)
      : path_(std::move(path)), file_(open_again_and_again(path_)) {
    expect_head();
    chunks_.emplace(file_);
    wav_.reset(chunks_->open(info_));
    chunks_->expect_readable();
    if (!wav_)
      fail(path_, std::string("is damaged in the chunks before its samples: ") + sf_strerror(nullptr));
    if ((info_.format & SF_FORMAT_SUBMASK) != SF_FORMAT_PCM_32)
      fail(path_, "allowed: 32-bit PCM, as rb export writes it");
    description_ = describe(path_, chunks_->comment(), info_.channels);
    // libsndfile does not notice that a file is cut: it believes the file's length, not its header.
    if (info_.frames != description_.rows) refuse_length(info_.frames);
    for (const auto& channel : description_.channel)
      channel_.push_back({.name = channel.name, .unit = channel.unit});
    sample_.resize(kRowsAtOnce * channel_.size());
  }

  const std::vector<FileChannel>& channels() const override { return channel_; }
  double part() const override {
    return static_cast<double>(row_) / static_cast<double>(std::max<std::int64_t>(1, description_.rows));
  }
  void rewind() override {
    row_ = 0;
    if (sf_seek(wav_.get(), 0, SEEK_SET) != 0) fail(path_, sf_strerror(wav_.get()));
  }
  bool read(SampleRows& rows) override {
    rows.clear();
    rows.channels = channel_.size();
    const auto frames = static_cast<std::size_t>(sf_readf_int(wav_.get(), sample_.data(), kRowsAtOnce));
    chunks_->expect_readable();
    for (std::size_t k = 0; k < frames; ++k, ++row_) {
      rows.time_s.push_back(description_.time_s(row_));
      for (std::size_t c = 0; c < channel_.size(); ++c)
        rows.value.push_back(value_of(sample_[k * channel_.size() + c], c));
    }
    if (frames == 0 && row_ != description_.rows) refuse_length(row_);
    return frames > 0;
  }

 private:
  /// Rejects a file that libsndfile would misread, or reject without naming the place.
  void expect_head() const {
    std::array<std::uint8_t, 12> head{};
    const std::size_t read = file_->read_at(0, head);
    const std::string text(head.begin(), head.begin() + static_cast<std::ptrdiff_t>(read));
    if (text.size() < head.size())
      fail(path_, "ends at byte " + std::to_string(text.size()) + ", in its header");
    if ((!text.starts_with("RIFF") && !text.starts_with("RF64")) || text.substr(8) != "WAVE")
      fail(path_, "byte 0: is no WAV file; allowed: RIFF or RF64 of WAVE");
  }
  [[noreturn]] void refuse_length(std::int64_t rows) const {
    fail(path_, "ends at byte " + std::to_string(file_->size()) + " after " + std::to_string(rows) + " of " +
                    std::to_string(description_.rows) + " samples");
  }
  double value_of(std::int32_t sample, std::size_t c) const {
    const Description::Channel& channel = description_.channel[c];
    const double counts = sample % kWavSamplesPerCount == 0
                              ? static_cast<double>(sample) / kWavSamplesPerCount
                              : std::numeric_limits<double>::quiet_NaN();  // no sample
    return (counts - channel.offset_counts) * channel.scale;
  }

  const std::filesystem::path path_;
  const std::shared_ptr<const File> file_;
  std::optional<WavChunks> chunks_;
  SF_INFO info_{};
  std::unique_ptr<SNDFILE, int (*)(SNDFILE*)> wav_{nullptr, sf_close};
  Description description_;
  std::vector<FileChannel> channel_;
  std::vector<std::int32_t> sample_;
  std::int64_t row_ = 0;
};

}  // namespace

std::unique_ptr<SampleSource> open_wav_samples(const std::filesystem::path& file) {
  return std::make_unique<WavSamples>(file);
}

}  // namespace roadbalance
