#pragma once

#include <array>
#include <cstdint>
#include <new>
#include <optional>
#include <span>

#include "firmware/board/board.hpp"
#include "firmware/board/test/simulated_hardware.hpp"

namespace roadbalance::board::test {

inline constexpr std::uint32_t kTickHz = 100'000'000;
inline constexpr std::uint32_t kTicksPerScan = 10'000;  // 10 kHz

/// The identity of the tests' board: 100 Hz to 20 kHz, filters of order 2, 4, 5, 6 and 8 from 50 Hz to 5 kHz.
Identity test_identity();
/// 10 kHz, no filter, no encoder.
Configuration test_configuration();

/// A board with its simulated hardware and a host's requests to it.
class Rig {
 public:
  Rig() : board(test_identity(), hardware) {}

  /// A fresh one in memory of its own: a board is too large for a stack.  Ends the one before in this place.
  static Rig& fresh(std::size_t place = 0);

  /// Sends an encoded structure; false: stalled.
  template <class Bytes>
  bool send(Request request, const Bytes& bytes) {
    return send_bytes(static_cast<std::uint8_t>(request), bytes);
  }
  bool send_bytes(std::uint8_t request, std::span<const std::uint8_t> bytes);
  bool stop() { return send_bytes(static_cast<std::uint8_t>(Request::kStop), {}); }
  /// Configures, arms and, unless as follower, starts.
  bool begin(const Configuration& configuration, StartMode mode = StartMode::kImmediate);

  Status status();

  /// The next packet, if one is due; it stays until the next call.
  std::optional<PacketView> packet();
  std::span<const std::uint8_t> packet_bytes_now() const { return {packet_.data(), size_}; }

  static constexpr std::uint32_t kToken = 0xC0FFEE;

  SimulatedHardware hardware;
  Board board;

 private:
  std::array<std::uint8_t, kTransferBytes> packet_{};
  std::size_t size_ = 0;
};

/// A scan whose channel k holds base + k.
ScanWords words_from(std::uint32_t base);

}  // namespace roadbalance::board::test
