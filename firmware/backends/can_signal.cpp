#include "firmware/backends/can_signal.hpp"

#include <charconv>

namespace roadbalance {
namespace {

/// Takes what stands before `end` off the front of `text`.
std::optional<std::string_view> take_until(char end, std::string_view& text) {
  const auto place = text.find(end);
  if (place == std::string_view::npos) return std::nullopt;
  const auto word = text.substr(0, place);
  text.remove_prefix(place + 1);
  return word;
}

template <typename Integer>
std::optional<Integer> whole_number(std::string_view text, int base) {
  Integer value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<CanFrame> parse_candump(std::string_view line) {
  if (line.empty() || line.front() != '(') return std::nullopt;
  line.remove_prefix(1);
  const auto seconds_text = take_until('.', line);
  const auto micros_text = take_until(')', line);
  if (!seconds_text || !micros_text || micros_text->size() != 6 || line.empty() || line.front() != ' ')
    return std::nullopt;
  line.remove_prefix(1);
  const auto interface = take_until(' ', line);
  const auto id_text = take_until('#', line);
  if (!interface || interface->empty() || !id_text || (id_text->size() != 3 && id_text->size() != 8))
    return std::nullopt;

  const auto seconds = whole_number<std::uint32_t>(*seconds_text, 10);
  const auto micros = whole_number<std::uint32_t>(*micros_text, 10);
  const auto id = whole_number<std::uint32_t>(*id_text, 16);
  CanFrame frame;
  frame.extended = id_text->size() == 8;
  const std::uint32_t highest_id = frame.extended ? 0x1FFF'FFFF : 0x7FF;
  if (!seconds || !micros || !id || *id > highest_id) return std::nullopt;
  frame.time_ns = *seconds * 1'000'000'000LL + *micros * 1'000LL;
  frame.interface = *interface;
  frame.id = *id;

  frame.size = line.size() / 2;
  if (line.size() % 2 != 0 || frame.size > frame.data.size()) return std::nullopt;
  for (std::size_t i = 0; i < frame.size; ++i) {
    const auto byte = whole_number<std::uint8_t>(line.substr(2 * i, 2), 16);
    if (!byte) return std::nullopt;
    frame.data[i] = *byte;
  }
  return frame;
}

std::optional<double> CanSignal::value(const CanFrame& frame) const {
  if (length < 1 || length > 64) return std::nullopt;
  std::uint64_t raw = 0;
  int bit = start_bit;
  for (int n = 0; n < length; ++n) {
    if (bit < 0 || bit >= static_cast<int>(8 * frame.size)) return std::nullopt;
    const std::uint64_t one = frame.data[static_cast<std::size_t>(bit / 8)] >> (bit % 8) & 1U;
    if (order == ByteOrder::kBigEndian) {
      raw = raw << 1 | one;
      bit = bit % 8 == 0 ? bit + 15 : bit - 1;
    } else {
      raw |= one << n;
      ++bit;
    }
  }
  if (!is_signed) return static_cast<double>(raw) * scale + offset;
  // The sign bit stands for -2^(length-1): shift it to the top and back.
  const auto number = static_cast<std::int64_t>(raw << (64 - length)) >> (64 - length);
  return static_cast<double>(number) * scale + offset;
}

}  // namespace roadbalance
