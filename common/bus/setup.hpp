#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

std::string setup_channel(std::int32_t node);  ///< "RB_SETUP_1"

/// Bits of setup_t.encoder.
enum class EncoderTrait : std::int32_t {
  kZeroMark = 1,
  kQuadrature = 2,
  kCountedOnBus = 4,  ///< its teeth come from a pulse counter on the car's bus
};

/// The set-up of a node; fields as in common/wire/setup_t.
struct NodeSetup {
  struct Channel {
    std::string name;  ///< cut after 32 bytes
    ChannelRole role = ChannelRole::kAcceleration;
    std::int32_t mount = -1;
    std::array<float, 3> position_m{}, direction{};
    float range_m_s2 = 0, scale_m_s2_per_count = 0, offset_counts = 0, delay_s = 0;
  };
  struct Encoder {
    std::int32_t wheel = -1;
    std::int32_t pulses_per_turn = 0;
    std::int32_t traits = 0;  ///< OR of EncoderTrait
    double datum_rad = 0, datum_sigma_rad = 0;
  };
  std::int32_t node = 0;
  std::string name, vehicle;
  std::uint32_t vehicle_crc32c = 0;
  double rate_hz = 0;
  std::int32_t filter_order = 0;
  double filter_cutoff_hz = 0;
  std::vector<Channel> channel;  ///< at most kAccelerations
  std::array<Encoder, kEncoderLines> encoder;
};

/// The set-up of a node of a vehicle.
NodeSetup setup_of(const VehicleConfig& vehicle, const NodeConfig& node);

std::vector<std::uint8_t> encode(const NodeSetup& setup);
std::optional<NodeSetup> decode_setup(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
