#pragma once

#include <array>
#include <cstdint>

#include "common/types/clocks.hpp"

namespace roadbalance {

inline constexpr int kAccelerations = 12;  ///< acceleration channels of a node, sampled simultaneously
inline constexpr int kReferences = 4;      ///< sin, cos of the angle of each of the node's two wheels
inline constexpr int kChannels = kAccelerations + kReferences;
inline constexpr int kEncoderLines = 2;            ///< wheel encoders of a node
inline constexpr std::int16_t kMostSignals = 256;  ///< of a node

/// Full scale of every channel: converters are 24 bit; a reference of 1.0 is this many counts.
inline constexpr std::int32_t kFullScaleCounts = 1 << 23;

/// Twelve simultaneous conversions, of a device with loop-back sixteen.
struct Scan {
  std::int64_t index = 0;  ///< counted by the device from 0; a jump means that scans were lost
  NodeTime time{};         ///< instant of conversion
  std::array<std::int32_t, kAccelerations> counts{};
  std::uint32_t overload = 0;  ///< bit k: channel k left its range
  /// The references as they came back through the real anti-aliasing filter; of a node with loop-back.
  std::array<std::int32_t, kReferences> references{};
  /// The scans jumped over are those of a device that was not there; its clock may have begun anew since.
  bool after_absence = false;
  bool after_sleep = false;  ///< the scans jumped over are those of a sleep of the node's computer
};

enum class EdgeKind : std::uint8_t {
  kTooth = 0,
  kZeroMark = 1,
  kToothBackward = 2,  ///< the second track shows that the wheel turned backwards
  kLost = 3,           ///< the device reports that it missed edges of this line before this instant
};

/// One rising edge of a wheel encoder.
struct Edge {
  NodeTime time{};
  std::uint8_t line = 0;  ///< which of the node's encoders, 0 .. kEncoderLines - 1
  EdgeKind kind = EdgeKind::kTooth;
};

/// A value that another device gives of the car at an instant: speed, steering angle, a pulse counter.
struct SignalSample {
  NodeTime time{};
  std::uint16_t signal = 0;  ///< which, in the order of vehicle.toml (NodeConfig::signal)
  double value = 0.0;        ///< in the unit of its SignalQuantity
};

}  // namespace roadbalance
