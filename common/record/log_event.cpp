#include "common/record/log_event.hpp"

#include <algorithm>

namespace roadbalance {
namespace {

constexpr std::array<std::uint8_t, 4> kSyncBytes{kLogSync >> 24, (kLogSync >> 16) & 0xFF,
                                                 (kLogSync >> 8) & 0xFF, kLogSync & 0xFF};

std::uint64_t load(const std::uint8_t* bytes, int count) {
  std::uint64_t value = 0;
  for (int k = 0; k < count; ++k) value = value << 8 | bytes[k];
  return value;
}

void store(std::uint64_t value, std::uint8_t* bytes, int count) {
  for (int k = count - 1; k >= 0; --k, value >>= 8) bytes[k] = static_cast<std::uint8_t>(value);
}

bool is_printable(std::span<const std::uint8_t> name) {
  return std::all_of(name.begin(), name.end(), [](std::uint8_t c) { return c > 0x20 && c < 0x7F; });
}

}  // namespace

std::array<std::uint8_t, kLogHeaderBytes> encode_log_header(const LogEvent& event) {
  std::array<std::uint8_t, kLogHeaderBytes> header{};
  store(kLogSync, header.data(), 4);
  store(static_cast<std::uint64_t>(event.number), header.data() + 4, 8);
  store(static_cast<std::uint64_t>(event.timestamp_us), header.data() + 12, 8);
  store(event.channel.size(), header.data() + 20, 4);
  store(event.data.size(), header.data() + 24, 4);
  return header;
}

bool may_begin_event(std::span<const std::uint8_t> bytes) {
  const std::size_t size = std::min(bytes.size(), kSyncBytes.size());
  return std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size), kSyncBytes.begin());
}

ParsedEvent parse_log_event(std::span<const std::uint8_t> bytes) {
  if (!may_begin_event(bytes)) return {};
  ParsedEvent incomplete;
  incomplete.status = ParsedEvent::Status::kIncomplete;
  if (bytes.size() < kLogHeaderBytes) return incomplete;

  const std::size_t name_size = load(bytes.data() + 20, 4);
  const std::size_t data_size = load(bytes.data() + 24, 4);
  if (name_size < 1 || name_size > kMaxLogChannelBytes || data_size > kMaxLogDataBytes) return {};
  const auto name = bytes.subspan(kLogHeaderBytes, std::min(name_size, bytes.size() - kLogHeaderBytes));
  if (!is_printable(name)) return {};
  const std::size_t total = kLogHeaderBytes + name_size + data_size;
  if (bytes.size() < total) return incomplete;

  ParsedEvent result;
  result.status = ParsedEvent::Status::kEvent;
  result.bytes = total;
  result.event.number = static_cast<std::int64_t>(load(bytes.data() + 4, 8));
  result.event.timestamp_us = static_cast<std::int64_t>(load(bytes.data() + 12, 8));
  result.event.channel = {reinterpret_cast<const char*>(name.data()), name_size};
  result.event.data = bytes.subspan(kLogHeaderBytes + name_size, data_size);
  return result;
}

}  // namespace roadbalance
