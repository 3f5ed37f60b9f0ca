#include "common/record/header_check.hpp"

#include "common/bus/notes.hpp"
#include "common/record/log_event.hpp"
#include "common/types/text_crc.hpp"

namespace roadbalance {

void HeaderSum::add(std::span<const std::uint8_t> header, std::string_view channel) {
  crc = crc32c(header, crc);
  crc = crc32c(channel, crc);
}

std::optional<std::uint64_t> HeaderCheck::take(int segment, std::uint64_t offset, const LogEvent& event) {
  if (segment != segment_) {
    segment_ = segment;
    next_ = 0;
    whole_ = true;
    sum_ = {};
  }
  whole_ = whole_ && offset == next_;
  next_ = offset + kLogHeaderBytes + event.channel.size() + event.data.size();
  std::optional<std::uint64_t> altered;
  if (event.channel == kCommitChannel) {
    const auto commit = decode_commit(event.data);
    // A commit from elsewhere: the one before was not seen as one, for its channel is altered.
    const bool is_so = commit && static_cast<std::uint64_t>(commit->headers_from) == sum_.from &&
                       commit->headers_crc32c == sum_.crc;
    if (whole_ && commit && !is_so) altered = sum_.from;
    whole_ = commit.has_value();
    sum_ = {.from = offset, .crc = 0};
  }
  sum_.add(encode_log_header(event), event.channel);
  return altered;
}

}  // namespace roadbalance
