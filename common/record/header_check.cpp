#include "common/record/header_check.hpp"

#include "common/bus/bus.hpp"
#include "common/bus/notes.hpp"
#include "common/record/log_event.hpp"
#include "common/types/crc32c.hpp"
#include "common/types/text_crc.hpp"

namespace roadbalance {
namespace {

// A node's block is covered by its sequence and by the sum in its epoch's end; node 0 is the recorder itself.
bool is_of_a_node(std::string_view channel) {
  constexpr std::string_view kOfBlocks(kBlockChannels);
  return channel.starts_with(kOfBlocks) && !channel.substr(kOfBlocks.size()).starts_with("0_");
}

}  // namespace

void HeaderSum::add(std::span<const std::uint8_t> header, std::string_view channel,
                    std::span<const std::uint8_t> data) {
  crc = crc32c(header, crc);
  crc = crc32c(channel, crc);
  if (!is_of_a_node(channel)) crc = crc32c(data, crc);
}

std::optional<std::uint64_t> HeaderCheck::take(int segment, std::uint64_t offset, const LogEvent& event) {
  if (segment != segment_) {
    segment_ = segment;
    next_ = 0;
    whole_ = true;
    sum_ = {};
    headers_crc_ = 0;
  }
  whole_ = whole_ && offset == next_;
  next_ = offset + kLogHeaderBytes + event.channel.size() + event.data.size();
  std::optional<std::uint64_t> altered;
  if (event.channel == kCommitChannel) {
    const auto commit = decode_commit(event.data);
    // A commit from elsewhere: the one before was not seen as one, for its channel is altered.
    const bool is_so = commit && static_cast<std::uint64_t>(commit->headers_from) == sum_.from &&
                       (commit->headers_crc32c == sum_.crc || commit->headers_crc32c == headers_crc_);
    if (whole_ && commit && !is_so) altered = sum_.from;
    whole_ = commit.has_value();
    sum_ = {.from = offset, .crc = 0};
    headers_crc_ = 0;
  }
  const auto header = encode_log_header(event);
  sum_.add(header, event.channel, event.data);
  headers_crc_ = crc32c(event.channel, crc32c(header, headers_crc_));
  const bool is_entry = event.channel.starts_with("RB_") && !is_of_a_node(event.channel);
  whole_ = whole_ && (!is_entry || ends_with_its_crc(event.data));
  return altered;
}

}  // namespace roadbalance
