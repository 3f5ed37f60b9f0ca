#include "common/record/segment_events.hpp"

#include "common/bus/notes.hpp"
#include "common/record/log_event.hpp"

namespace roadbalance {

std::uint64_t commit_event_bytes() {
  static const std::uint64_t bytes =
      kLogHeaderBytes + std::string_view(kCommitChannel).size() + encode(Commit()).size();
  return bytes;
}

void SegmentEvents::put(std::string_view channel, std::span<const std::uint8_t> data) {
  const LogEvent event{
      .number = event_number++, .timestamp_us = last_timestamp_us, .channel = channel, .data = data};
  const auto header = encode_log_header(event);
  headers.add(header, channel, data);
  buffer.insert(buffer.end(), header.begin(), header.end());
  buffer.insert(buffer.end(), channel.begin(), channel.end());
  buffer.insert(buffer.end(), data.begin(), data.end());
  segment_bytes += header.size() + channel.size() + data.size();
}

void SegmentEvents::put_commit(std::uint64_t durable_bytes) {
  const Commit commit{.bytes = static_cast<std::int64_t>(durable_bytes),
                      .headers_from = static_cast<std::int64_t>(headers.from),
                      .headers_crc32c = headers.crc};
  headers = {.from = segment_bytes, .crc = 0};
  put(kCommitChannel, encode(commit));
}

void SegmentEvents::put_last_commit(std::uint64_t durable_bytes) {
  const std::uint64_t covered = headers.from > 0 ? headers.from + commit_event_bytes() : 0;
  if (segment_bytes > covered) put_commit(durable_bytes);
}

}  // namespace roadbalance
