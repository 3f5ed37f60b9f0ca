#include "host/recording/formats/wav_chunks.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <utility>

#include "common/config/section.hpp"
#include "common/text/printable.hpp"

namespace roadbalance {
namespace {

constexpr std::uint64_t kRiffHeader = 12, kChunkHead = 8, kListType = 4, kMostCommentBytes = 1 << 24;
constexpr std::string_view kSkipped = "JUNK";
constexpr std::uint64_t kSizeInDs64 = 0xFFFFFFFF;  // length of RF64's data

}  // namespace

/// A chunk of RIFF: four letters, length (32 bits, little endian), data, padded to an even length.
struct WavChunks::Chunk {
  std::string id;
  std::uint64_t data, size;  ///< where its data begin, and their bytes
  std::uint64_t next() const { return data + size + size % 2; }

  static std::optional<Chunk> at(const File& file, std::uint64_t at, std::uint64_t end) {
    std::array<std::uint8_t, kChunkHead> head{};
    if (at + head.size() > end || file.read_at(at, head) != head.size()) return std::nullopt;
    std::uint64_t size = 0;
    for (std::size_t k = 0; k < 4; ++k) size |= std::uint64_t{head[4 + k]} << 8 * k;
    return Chunk{std::string(head.begin(), head.begin() + 4), at + head.size(), size};
  }
  void expect_within(const File& file, std::uint64_t end, const char* whole) const {
    if (size <= end - data) return;
    throw ConfigError(file.path().string() + ": byte " + std::to_string(data - kChunkHead) + ": chunk " +
                      printable_text(id) + " tells " + std::to_string(size) + " bytes; its " + whole +
                      " ends at byte " + std::to_string(end));
  }
};

WavChunks::WavChunks(std::shared_ptr<const File> file) : file_(std::move(file)), end_(file_->size()) {
  const std::uint64_t end = end_;
  std::optional<Chunk> chunk = Chunk::at(*file_, kRiffHeader, end);
  for (; chunk && chunk->id != "data"; chunk = Chunk::at(*file_, chunk->next(), end)) take(*chunk);
  if (!chunk) return;
  // Chunks behind the samples are not examined, and a file that is cut among the samples is not rejected
  // here.
  const std::uint64_t bytes = chunk->size == kSizeInDs64 ? data_bytes_.value_or(end) : chunk->size;
  end_ = chunk->data + std::min(bytes, end - chunk->data);
}

void WavChunks::take(const Chunk& chunk) {
  chunk.expect_within(*file_, end_, "file");
  if (chunk.id == "ds64") {  // length of the file, of the samples
    std::array<std::uint8_t, 16> lengths{};
    std::uint64_t bytes = 0;
    if (chunk.size >= lengths.size() && file_->read_at(chunk.data, lengths) == lengths.size())
      for (std::size_t k = 0; k < 8; ++k) bytes |= std::uint64_t{lengths[8 + k]} << 8 * k;
    data_bytes_ = bytes;
  }
  if (chunk.id == "fmt " || chunk.id == "fact" || chunk.id == "ds64") return;
  hidden_.push_back(chunk.data - kChunkHead);
  if (chunk.id == "LIST") take_list(chunk);
}

void WavChunks::take_list(const Chunk& list) {
  const std::uint64_t end = list.data + list.size;
  for (auto text = Chunk::at(*file_, list.data + kListType, end); text;
       text = Chunk::at(*file_, text->next(), end)) {
    text->expect_within(*file_, end, "list");
    if (comment_ || text->id != "ICMT" || text->size > kMostCommentBytes) continue;
    std::vector<std::uint8_t> bytes(text->size);
    bytes.resize(file_->read_at(text->data, bytes));
    comment_ = {text->data,
                std::string(bytes.begin(), std::find(bytes.begin(), bytes.end(), std::uint8_t{0}))};
  }
}

std::int64_t WavChunks::read(std::uint8_t* to, std::int64_t bytes) {
  const std::int64_t left = std::max<std::int64_t>(0, static_cast<std::int64_t>(end_) - at_);
  const auto wanted = static_cast<std::size_t>(std::clamp<std::int64_t>(bytes, 0, left));
  const auto from = static_cast<std::uint64_t>(at_);
  const std::size_t count = file_->read_at(from, std::span(to, wanted));
  const std::uint64_t end = from + count;
  for (auto name = std::ranges::lower_bound(hidden_, from - std::min<std::uint64_t>(from, kSkipped.size()));
       name != hidden_.end() && *name < end; ++name)
    for (std::uint64_t k = 0; k < kSkipped.size(); ++k)
      if (*name + k >= from && *name + k < end) to[*name + k - from] = static_cast<std::uint8_t>(kSkipped[k]);
  at_ += static_cast<std::int64_t>(count);
  return static_cast<std::int64_t>(count);
}

// Called by C, through which no exception may pass.
const SF_VIRTUAL_IO& WavChunks::calls() {
  static const SF_VIRTUAL_IO all{
      .get_filelen = [](void* of) { return static_cast<sf_count_t>(static_cast<WavChunks*>(of)->end_); },
      .seek = [](sf_count_t offset, int whence, void* of) -> sf_count_t {
        auto& self = *static_cast<WavChunks*>(of);
        const std::int64_t from = whence == SEEK_SET   ? 0
                                  : whence == SEEK_CUR ? self.at_
                                                       : static_cast<std::int64_t>(self.end_);
        std::int64_t to = 0;
        if (__builtin_add_overflow(from, offset, &to) || to < 0) return -1;
        return self.at_ = to;
      },
      .read = [](void* to, sf_count_t bytes, void* of) -> sf_count_t {
        auto& self = *static_cast<WavChunks*>(of);
        try {
          return self.read(static_cast<std::uint8_t*>(to), bytes);
        } catch (...) {
          self.failure_ = std::current_exception();
          return 0;
        }
      },
      .write = [](const void*, sf_count_t, void*) -> sf_count_t { return 0; },
      .tell = [](void* of) { return static_cast<sf_count_t>(static_cast<WavChunks*>(of)->at_); }};
  return all;
}

void WavChunks::expect_readable() const {
  if (failure_) std::rethrow_exception(failure_);
}

SNDFILE* WavChunks::open(SF_INFO& info) {
  return sf_open_virtual(const_cast<SF_VIRTUAL_IO*>(&calls()), SFM_READ, &info, this);
}

}  // namespace roadbalance
