#include "firmware/backends/socketcan/accelerometer_frame.hpp"

namespace roadbalance {
namespace {

constexpr std::uint16_t kAllChannels = (1 << kAccelerations) - 1;
constexpr std::size_t kPartHead = 2, kFlexibleHead = 8;

std::uint16_t read_16(const CanFrame& frame, std::size_t at) {
  return static_cast<std::uint16_t>(frame.data[at] | frame.data[at + 1] << 8);
}

void write_16(std::uint16_t value, CanFrame& frame, std::size_t at) {
  frame.data[at] = static_cast<std::uint8_t>(value);
  frame.data[at + 1] = static_cast<std::uint8_t>(value >> 8);
}

}  // namespace

std::optional<AccelerometerFrame> read_accelerometer(const CanFrame& frame, std::uint32_t first_id) noexcept {
  const std::uint32_t place = frame.id - first_id;
  const std::uint32_t parts = frame.is_fd ? 1 : AccelerometerFrame::kParts;
  if (frame.extended || place >= parts) return std::nullopt;
  if (frame.size != (frame.is_fd ? AccelerometerFrame::kFdBytes : kClassicCanBytes)) return std::nullopt;
  if (frame.data[0] >> 4 != AccelerometerFrame::kVersion) return std::nullopt;

  AccelerometerFrame content;
  if (frame.is_fd) {
    content.overload = read_16(frame, 2);
    if ((frame.data[0] & 0xF) != 0 || frame.data[1] != 0 || content.overload > kAllChannels)
      return std::nullopt;
    content.sequence = read_16(frame, 4) | static_cast<std::uint32_t>(read_16(frame, 6)) << 16;
    for (std::size_t k = 0; k < content.sample.size(); ++k)
      content.sample[k] = static_cast<std::int16_t>(read_16(frame, kFlexibleHead + 2 * k));
    return content;
  }
  if ((frame.data[0] & 0x8) != 0) return std::nullopt;
  content.part = static_cast<int>(place);
  content.sequence = frame.data[1];
  const std::size_t first = place * AccelerometerFrame::kChannelsOfPart;
  content.overload = static_cast<std::uint16_t>((frame.data[0] & 0x7) << first);
  for (std::size_t k = 0; k < AccelerometerFrame::kChannelsOfPart; ++k)
    content.sample[first + k] = static_cast<std::int16_t>(read_16(frame, kPartHead + 2 * k));
  return content;
}

CanFrame write_accelerometer(const AccelerometerFrame& content, std::uint32_t first_id) {
  CanFrame frame{.id = first_id + static_cast<std::uint32_t>(content.part.value_or(0))};
  frame.is_fd = !content.part;
  frame.data[0] = AccelerometerFrame::kVersion << 4;
  if (frame.is_fd) {
    frame.size = AccelerometerFrame::kFdBytes;
    write_16(content.overload, frame, 2);
    write_16(static_cast<std::uint16_t>(content.sequence), frame, 4);
    write_16(static_cast<std::uint16_t>(content.sequence >> 16), frame, 6);
    for (std::size_t k = 0; k < content.sample.size(); ++k)
      write_16(static_cast<std::uint16_t>(content.sample[k]), frame, kFlexibleHead + 2 * k);
    return frame;
  }
  frame.size = kClassicCanBytes;
  const auto first = static_cast<std::size_t>(*content.part * AccelerometerFrame::kChannelsOfPart);
  frame.data[0] = static_cast<std::uint8_t>(frame.data[0] | (content.overload >> first & 0x7));
  frame.data[1] = static_cast<std::uint8_t>(content.sequence);
  for (std::size_t k = 0; k < AccelerometerFrame::kChannelsOfPart; ++k)
    write_16(static_cast<std::uint16_t>(content.sample[first + k]), frame, kPartHead + 2 * k);
  return frame;
}

}  // namespace roadbalance
