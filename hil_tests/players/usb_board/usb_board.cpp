#include "hil_tests/players/usb_board/usb_board.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "firmware/board/byte_order.hpp"
#include "firmware/board/packet.hpp"

namespace roadbalance::test {
namespace {

using board::SetupPacket;

constexpr std::uint8_t kStringIds[] = {4, 3, 0x09, 0x04};  // English (United States)
constexpr std::uint8_t kDeviceDescriptor[] = {18,   1,    0x00, 0x02, 0xFF, 0, 0, 64, 0x09,
                                              0x12, 0x01, 0x00, 0x00, 0x01, 1, 2, 3,  1};
constexpr std::uint8_t kConfigurationDescriptor[] = {9, 2,    25, 0, 1, 1, 0, 0x80, 50, 9, 4, 0, 0,
                                                     1, 0xFF, 0,  0, 0, 7, 5, 0x81, 2,  0, 2, 0};
/// Bytes that a newer minor version may append to its packets.
constexpr std::size_t kAppendedBytes = 8;

SetupPacket setup_of(const std::array<std::uint8_t, 8>& bytes) {
  board::ByteReader in(bytes);
  SetupPacket setup;
  setup.request_type = in.take<std::uint8_t>();
  setup.request = in.take<std::uint8_t>();
  setup.value = in.take<std::uint16_t>();
  setup.index = in.take<std::uint16_t>();
  setup.length = in.take<std::uint16_t>();
  return setup;
}

std::size_t copied(std::span<const std::uint8_t> from, std::span<std::uint8_t> to) {
  const std::size_t size = std::min(from.size(), to.size());
  std::copy_n(from.begin(), size, to.begin());
  return size;
}

/// A packet as a board of a newer minor version sends it: a longer header.
std::size_t make_newer(std::span<std::uint8_t> packet, std::size_t size, std::uint16_t minor) {
  if (size + kAppendedBytes > board::kMaxPacketBytes) return size;
  std::memmove(&packet[board::kHeaderBytes + kAppendedBytes], &packet[board::kHeaderBytes],
               size - board::kHeaderBytes);
  std::fill_n(packet.begin() + board::kHeaderBytes, kAppendedBytes, std::uint8_t{0xA5});
  packet[5] = static_cast<std::uint8_t>(minor);
  packet[6] = board::kHeaderBytes + kAppendedBytes;
  board::seal_packet(packet.first(size + kAppendedBytes));
  return size + kAppendedBytes;
}

/// True for one of those that were wanted.
bool take_one(std::atomic<int>& count) {
  if (count.load(std::memory_order_relaxed) <= 0) return false;
  count.fetch_sub(1, std::memory_order_relaxed);
  return true;
}

}  // namespace

std::optional<std::size_t> UsbBoard::descriptor(std::uint16_t which, std::span<std::uint8_t> reply) const {
  switch (which >> 8) {
    case 1:
      return copied(kDeviceDescriptor, reply);
    case 2:
      return copied(kConfigurationDescriptor, reply);
    case 3:
      break;
    default:
      return std::nullopt;
  }
  const std::size_t index = which & 0xFF;
  const std::array<std::string, 4> texts{"", "roadbalance", "front-end board", board_.bench().serial};
  if (index >= texts.size()) return std::nullopt;
  if (index == 0) return copied(kStringIds, reply);
  std::vector<std::uint8_t> text{static_cast<std::uint8_t>(2 + 2 * texts[index].size()), 3};
  for (const char letter : texts[index]) {
    text.push_back(static_cast<std::uint8_t>(letter));
    text.push_back(0);
  }
  return copied(text, reply);
}

std::optional<std::size_t> UsbBoard::standard_request(const SetupPacket& setup,
                                                      std::span<std::uint8_t> reply) {
  constexpr std::uint8_t kZeros[2] = {0, 0}, kOne[1] = {1};
  switch (setup.request_type << 8 | setup.request) {
    case 0x8006:  // GET_DESCRIPTOR
      return descriptor(setup.value, reply);
    case 0x8000:  // GET_STATUS of the device, interface, endpoint
    case 0x8100:
    case 0x8200:
      return copied(kZeros, reply);
    case 0x8008:  // GET_CONFIGURATION
      return copied(kOne, reply);
    case 0x0009:  // SET_CONFIGURATION
      board_.reset();
      halted_ = false;
      return 0;
    case 0x010B:  // SET_INTERFACE
      return 0;
    case 0x0201:  // CLEAR_FEATURE(ENDPOINT_HALT)
      halted_ = false;
      return 0;
    default:
      return std::nullopt;
  }
}

void UsbBoard::answer_control(const Urb& urb) {
  constexpr std::uint8_t kVendor = 0x40;
  const SetupPacket setup = setup_of(urb.setup);
  std::array<std::uint8_t, 512> buffer{};
  const std::span<std::uint8_t> reply =
      std::span(buffer).first(std::min<std::size_t>(setup.length, buffer.size()));
  std::optional<std::size_t> size;
  if ((setup.request_type & 0x60) != kVendor) {
    size = standard_request(setup, reply);
  } else {
    if (take_one(faults_.deaf)) return;
    board_.advance(MachineClock::now());
    size = board_.control_request(setup, urb.data, reply);
    const bool newer = board_.bench().minor > board::kProtocolMinor;
    if (size && newer && urb.in && *size + kAppendedBytes <= reply.size()) *size += kAppendedBytes;
  }
  port_.complete(urb, size ? 0 : UsbipPort::kStalled, reply.first(size.value_or(0)));
}

void UsbBoard::handle() {
  const auto urb = port_.receive(waiting_);
  if (!urb) return;
  if (urb->endpoint == 0)
    answer_control(*urb);
  else
    waiting_.push_back(*urb);
}

std::size_t UsbBoard::spoil(std::span<std::uint8_t> packet, std::size_t size) {
  if (board_.bench().minor > board::kProtocolMinor) size = make_newer(packet, size, board_.bench().minor);
  if (take_one(faults_.drop)) return 0;
  if (take_one(faults_.corrupt)) packet[size / 2] ^= 0x10;
  if (take_one(faults_.cut)) size = size / 2 + 1;
  return size;
}

void UsbBoard::serve() {
  std::array<std::uint8_t, board::kTransferBytes> packet;
  while (port_.socket() >= 0 && !waiting_.empty() && !faults_.held) {
    if (take_one(faults_.stall)) halted_ = true;
    if (halted_) {
      for (const Urb& urb : waiting_) port_.complete(urb, UsbipPort::kStalled, {});
      waiting_.clear();
      return;
    }
    std::size_t size = board_.next_packet(packet);
    if (size == 0) return;
    size = spoil(packet, size);
    if (size == 0) continue;
    packets_sent_.fetch_add(1, std::memory_order_relaxed);
    port_.complete(waiting_.front(), 0, std::span(packet).first(size));
    waiting_.erase(waiting_.begin());
  }
}

void UsbBoard::power_off() {
  waiting_.clear();
  halted_ = false;
  board_.reset();
}

}  // namespace roadbalance::test
