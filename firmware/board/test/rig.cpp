#include "firmware/board/test/rig.hpp"

#include "firmware/board/test/check.hpp"

namespace roadbalance::board::test {

Identity test_identity() {
  Identity identity;
  identity.firmware_version = 1u << 16;
  identity.serial = {'T', 'E', 'S', 'T', '1'};
  identity.capabilities = kHasReferences | kHasQuadrature | kHasSync | kHasTestPattern;
  identity.tick_hz = kTickHz;
  identity.rate_min_hz = 100;
  identity.rate_max_hz = 20'000;
  identity.filter_min_hz = 50;
  identity.filter_max_hz = 5'000;
  identity.filter_orders = 1u << 0 | 1u << 2 | 1u << 4 | 1u << 5 | 1u << 6 | 1u << 8;
  identity.full_scale_uv = {10'000'000, 5'000'000, 2'500'000, 1'250'000};
  return identity;
}

Configuration test_configuration() {
  Configuration configuration;
  configuration.ticks_per_scan = kTicksPerScan;
  return configuration;
}

Rig& Rig::fresh(std::size_t place) {
  alignas(Rig) static std::array<std::array<std::byte, sizeof(Rig)>, 2> memory;
  static std::array<Rig*, 2> rigs{};
  if (rigs[place] != nullptr) rigs[place]->~Rig();
  rigs[place] = new (memory[place].data()) Rig;
  return *rigs[place];
}

bool Rig::send_bytes(std::uint8_t request, std::span<const std::uint8_t> bytes) {
  const SetupPacket setup{kVendorOut, request, 0, 0, static_cast<std::uint16_t>(bytes.size())};
  return board.control_request(setup, bytes, {}).has_value();
}

bool Rig::begin(const Configuration& configuration, StartMode mode) {
  if (!send(Request::kConfigure, encode(configuration))) return false;
  if (!send(Request::kArm, encode(Arm{kToken, mode}))) return false;
  return mode == StartMode::kFollower || send(Request::kStart, encode(Start{kToken}));
}

Status Rig::status() {
  std::array<std::uint8_t, Status::kBytes> bytes{};
  const SetupPacket setup{kVendorIn, static_cast<std::uint8_t>(Request::kStatus), 0, 0, Status::kBytes};
  const auto size = board.control_request(setup, {}, bytes);
  CHECK(size == Status::kBytes);
  const auto status = decode_status(bytes);
  CHECK(status.has_value());
  return status.value_or(Status{});
}

std::optional<PacketView> Rig::packet() {
  size_ = board.next_packet(packet_);
  if (size_ == 0) return std::nullopt;
  PacketFault fault = PacketFault::kNone;
  auto view = decode_packet({packet_.data(), size_}, &fault);
  CHECK_EQUAL(fault, PacketFault::kNone);
  return view;
}

ScanWords words_from(std::uint32_t base) {
  ScanWords words{};
  for (std::uint32_t k = 0; k < words.size(); ++k) words[k] = (base + k) & 0xFFFFFF;
  return words;
}

}  // namespace roadbalance::board::test
