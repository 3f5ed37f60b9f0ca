#include "host/recording/formats/wav_writer.hpp"

#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "host/recording/formats/description_json.hpp"
#include "host/recording/formats/only_group.hpp"
#include "host/recording/formats/wav_scale.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kMostChannels = 1024;  // of libsndfile

constexpr std::int64_t kMostCounts = 2147483647 / kWavSamplesPerCount;

std::int32_t sample_of(std::int64_t counts) {
  return static_cast<std::int32_t>(std::clamp(counts, -kMostCounts, kMostCounts) * kWavSamplesPerCount);
}

/// The value of a missing sample: all but silent, and unlike any sample.
std::int32_t missing_at(double offset_counts) {
  constexpr auto kLimit = static_cast<double>(kMostCounts);
  return sample_of(std::llround(std::floor(std::clamp(offset_counts, -kLimit, kLimit)))) + kWavMissing;
}

class WavWriter final : public ExportWriter {
 public:
  WavWriter(const std::filesystem::path& file, const ExportTable& table) : path_(file.string()) {
    const ExportGroup& group = only_group(table, "wav");
    channels_ = group.channel.size();
    if (channels_ > kMostChannels)
      throw ConfigError("wav: " + std::to_string(channels_) + " channels; allowed: 1 .. 1024 (--channels)");
    for (const auto& channel : group.channel) missing_.push_back(missing_at(channel.offset_counts));
    SF_INFO info{};
    info.samplerate = static_cast<int>(std::max(1L, std::lround(group.rate_hz)));
    info.channels = static_cast<int>(channels_);
    info.format = SF_FORMAT_RF64 | SF_FORMAT_PCM_32;
    file_ = sf_open(path_.c_str(), SFM_WRITE, &info);
    if (file_ == nullptr) throw std::runtime_error("write " + path_ + ": " + sf_strerror(nullptr));
    sf_command(file_, SFC_RF64_AUTO_DOWNGRADE, nullptr, SF_TRUE);  // WAV if it is short enough
    sf_set_string(file_, SF_STR_SOFTWARE, "roadbalance");
    sf_set_string(file_, SF_STR_COMMENT, description_json(table).c_str());
  }
  ~WavWriter() override {
    if (file_ != nullptr) sf_close(file_);
  }

  void add(std::size_t, const ExportRows& rows) override {
    samples_.resize(rows.counts.size());
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      samples_[i] = rows.counts[i] == kMissingCounts ? missing_[i % channels_] : sample_of(rows.counts[i]);
    }
    const auto count = static_cast<sf_count_t>(rows.rows());
    if (sf_writef_int(file_, samples_.data(), count) != count)
      throw std::runtime_error("write " + path_ + ": " + sf_strerror(file_));
  }

  void close() override {
    const int error = sf_close(file_);
    file_ = nullptr;
    if (error != 0) throw std::runtime_error("write " + path_ + ": " + sf_error_number(error));
  }

 private:
  const std::string path_;
  std::size_t channels_ = 0;
  std::vector<std::int32_t> missing_, samples_;
  SNDFILE* file_ = nullptr;
};

}  // namespace

std::unique_ptr<ExportWriter> make_wav_writer(const std::filesystem::path& file, const ExportTable& table) {
  return std::make_unique<WavWriter>(file, table);
}

}  // namespace roadbalance
