#include "host/exchange/wav_reader.hpp"

#include <sndfile.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "common/config/section.hpp"
#include "common/record/file.hpp"
#include "host/exchange/wav_scale.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;
constexpr sf_count_t kFrames = 4096;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& reason) {
  throw ConfigError(file.string() + ": " + reason);
}

/// A chunk of RIFF: four letters, length (32 bits, little endian), data, padded to an even length.
struct Chunk {
  std::string id;
  std::uint64_t data, size;  ///< where its data begin, and their bytes
  std::uint64_t next() const { return data + size + size % 2; }
};

std::optional<Chunk> chunk_at(const File& file, std::uint64_t at, std::uint64_t end) {
  std::array<std::uint8_t, 8> head{};
  if (at + head.size() > end || file.read_at(at, head) != head.size()) return std::nullopt;
  std::uint64_t size = 0;
  for (std::size_t k = 0; k < 4; ++k) size |= std::uint64_t{head[4 + k]} << 8 * k;
  const Chunk chunk{std::string(head.begin(), head.begin() + 4), at + head.size(), size};
  return chunk.data + chunk.size <= end ? std::optional(chunk) : std::nullopt;
}

/// INFO ICMT, which stands before the samples; nothing if there is none.  libsndfile drops one of more than 8
/// kB.
std::optional<std::string> comment_of(const std::filesystem::path& path) {
  constexpr std::uint64_t kRiffHeader = 12, kListType = 4, kMostText = 1 << 24;
  const File file = File::open_to_read(path);
  const std::uint64_t end = file.size();
  for (auto chunk = chunk_at(file, kRiffHeader, end); chunk && chunk->id != "data";
       chunk = chunk_at(file, chunk->next(), end)) {
    if (chunk->id != "LIST" || chunk->size < kListType) continue;
    const std::uint64_t list_end = chunk->data + chunk->size;
    for (auto text = chunk_at(file, chunk->data + kListType, list_end); text;
         text = chunk_at(file, text->next(), list_end)) {
      if (text->id != "ICMT" || text->size > kMostText) continue;
      std::vector<std::uint8_t> bytes(text->size);
      bytes.resize(file.read_at(text->data, bytes));
      return std::string(bytes.begin(), std::find(bytes.begin(), bytes.end(), std::uint8_t{0}));
    }
  }
  return std::nullopt;
}

struct Description {
  double rate_hz, first_s;
  std::int64_t rows;
  struct Channel {
    std::string name;
    double scale, offset_counts;
  };
  std::vector<Channel> channel;
};

/// As description_json() wrote it.
Description describe(const std::filesystem::path& file, int channels) {
  const auto comment = comment_of(file);
  if (!comment) fail(file, "has no comment that tells its channels and scales; allowed: a file of rb export");
  try {
    const Json json = Json::parse(*comment);
    const Json& group = json.at("groups").at(0);
    Description found{group.at("rate_hz").get<double>(),
                      group.at("first_s").get<double>(),
                      group.at("rows").get<std::int64_t>(),
                      {}};
    std::set<std::string> seen;
    for (const Json& channel : group.at("channels")) {
      found.channel.push_back({channel.at("name").get<std::string>(), channel.at("scale").get<double>(),
                               channel.at("offset_counts").get<double>()});
      if (!seen.insert(found.channel.back().name).second)
        fail(file, "channel " + found.channel.back().name + " stands twice in its comment");
    }
    if (std::ssize(found.channel) != channels)
      fail(file, std::to_string(channels) + " channels, but its comment tells " +
                     std::to_string(found.channel.size()));
    if (!(found.rate_hz > 0.0)) fail(file, "rate_hz in its comment is not above 0");
    return found;
  } catch (const Json::exception& error) {
    fail(file, std::string("its comment is not that of rb export: ") + error.what());
  }
}

}  // namespace

SampleTable read_wav_samples(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file))
    throw std::system_error(ENOENT, std::generic_category(), "open " + file.string());
  SF_INFO info{};
  const std::unique_ptr<SNDFILE, int (*)(SNDFILE*)> wav(sf_open(file.c_str(), SFM_READ, &info), sf_close);
  if (!wav) fail(file, std::string("is no sound file, or damaged at its beginning: ") + sf_strerror(nullptr));
  if ((info.format & SF_FORMAT_SUBMASK) != SF_FORMAT_PCM_32)
    fail(file, "allowed: 32-bit PCM, as rb export writes it");
  const Description description = describe(file, info.channels);
  SampleTable table;
  const std::size_t channels = description.channel.size();
  for (const auto& channel : description.channel) table.name.push_back(channel.name);
  table.value_si.resize(channels);
  std::vector<std::int32_t> samples(static_cast<std::size_t>(kFrames) * channels);
  while (const sf_count_t frames = sf_readf_int(wav.get(), samples.data(), kFrames)) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(frames) * channels; ++i) {
      const Description::Channel& channel = description.channel[i % channels];
      const double counts = samples[i] % kWavSamplesPerCount == 0
                                ? static_cast<double>(samples[i]) / kWavSamplesPerCount
                                : std::numeric_limits<double>::quiet_NaN();  // no sample
      table.value_si[i % channels].push_back((counts - channel.offset_counts) * channel.scale);
    }
    for (sf_count_t k = 0; k < frames; ++k)
      table.time_s.push_back(description.first_s +
                             static_cast<double>(table.time_s.size()) / description.rate_hz);
  }
  // A file that is cut is none to libsndfile: it believes the file's length, not its header.
  if (std::ssize(table.time_s) != description.rows)
    fail(file, "ends at byte " + std::to_string(std::filesystem::file_size(file)) + " after " +
                   std::to_string(table.time_s.size()) + " of " + std::to_string(description.rows) +
                   " samples");
  return table;
}

}  // namespace roadbalance
