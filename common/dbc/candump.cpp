#include "common/dbc/candump.hpp"

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

/// "(seconds.microseconds) " off the front of `line`.
std::optional<std::int64_t> take_time_ns(std::string_view& line) {
  if (line.empty() || line.front() != '(') return std::nullopt;
  line.remove_prefix(1);
  const auto seconds_text = take_until('.', line);
  const auto micros_text = take_until(')', line);
  if (!seconds_text || !micros_text || micros_text->size() != 6 || line.empty() || line.front() != ' ')
    return std::nullopt;
  line.remove_prefix(1);
  const auto seconds = whole_number<std::uint32_t>(*seconds_text, 10);
  const auto micros = whole_number<std::uint32_t>(*micros_text, 10);
  if (!seconds || !micros) return std::nullopt;
  return *seconds * 1'000'000'000LL + *micros * 1'000LL;
}

/// The part behind the first '#', into `frame`.
bool read_data(std::string_view text, CanFrame& frame) {
  if (!text.empty() && text.front() == '#') {
    frame.is_fd = true;
    text.remove_prefix(1);
    if (text.empty() || !whole_number<std::uint8_t>(text.substr(0, 1), 16)) return false;
    text.remove_prefix(1);
  }
  const std::size_t size = text.size() / 2;
  if (text.size() % 2 != 0 || !is_can_size(size, frame.is_fd)) return false;
  frame.size = static_cast<std::uint8_t>(size);
  for (std::size_t i = 0; i < size; ++i) {
    const auto byte = whole_number<std::uint8_t>(text.substr(2 * i, 2), 16);
    if (!byte) return false;
    frame.data[i] = *byte;
  }
  return true;
}

}  // namespace

std::optional<LoggedFrame> parse_candump(std::string_view line) {
  const auto time_ns = take_time_ns(line);
  const auto interface = take_until(' ', line);
  const auto id_text = take_until('#', line);
  if (!time_ns || !interface || interface->empty() || !id_text ||
      (id_text->size() != 3 && id_text->size() != 8))
    return std::nullopt;
  LoggedFrame logged{.time_ns = *time_ns, .interface = std::string(*interface), .frame = {}};
  const auto id = whole_number<std::uint32_t>(*id_text, 16);
  logged.frame.extended = id_text->size() == 8;
  if (!id || *id > (logged.frame.extended ? kHighestExtendedId : kHighestStandardId)) return std::nullopt;
  logged.frame.id = *id;
  if (!read_data(line, logged.frame)) return std::nullopt;
  return logged;
}

}  // namespace roadbalance
