#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/clock/clocks.hpp"
#include "common/frontend/device_report.hpp"

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
};

enum class EdgeKind : std::uint8_t {
  kTooth = 0,
  kZeroMark = 1,
  kToothBackward = 2,  ///< the second track says that the wheel turned backwards
  kLost = 3,           ///< the device knows that it missed edges of this line before this instant
};

/// One rising edge of a wheel encoder.
struct Edge {
  NodeTime time{};
  std::uint8_t line = 0;  ///< which of the node's encoders, 0 .. kEncoderLines - 1
  EdgeKind kind = EdgeKind::kTooth;
};

enum class ReadStatus {
  kOk,
  kEnd,     ///< the device has no more, e.g. a recording is over; what was returned still counts
  kFailed,  ///< the device is gone; what was returned still counts
};

/// What another device says of the car at an instant: speed, steering angle, a pulse counter.
struct SignalSample {
  NodeTime time{};
  std::uint16_t signal = 0;  ///< which, in the order of vehicle.toml (NodeConfig::signal)
  double value = 0.0;        ///< in the unit of its SignalQuantity
};

struct Read {
  std::size_t scans = 0;    ///< how many of the given scans were filled
  std::size_t edges = 0;    ///< how many of the given edges were filled
  std::size_t signals = 0;  ///< how many of the given signal samples were filled
  ReadStatus status = ReadStatus::kOk;
};

/// What the time of a scan is.
enum class ScanStamps {
  kConversion,  ///< the instant of conversion, up to the stamp's resolution
  kReadOut,     ///< when the scan was read from the device: later than its conversion, and unevenly so
};

/// A source of scans and edges: hardware, the simulated car or a recording, chosen by URI at run time.
class FrontEnd {
 public:
  FrontEnd() = default;
  FrontEnd(const FrontEnd&) = delete;
  FrontEnd& operator=(const FrontEnd&) = delete;
  virtual ~FrontEnd() = default;

  /// Waits until at least one scan is there (at most 100 ms) and hands over all there are, up to the
  /// spans' sizes, scans and edges each in order of time, samples in order of time for each signal.  Every
  /// edge stamped before the last returned scan has been returned by this or an earlier call, unless `edges`
  /// was full: then the rest comes next.
  /// The caller gives room for at least 64 edges and 64 samples.  Never allocates.
  virtual Read read(std::span<Scan> scans, std::span<Edge> edges,
                    std::span<SignalSample> signals) noexcept = 0;

  /// True if the device loses nothing while nobody reads it (a simulation faster than real time, a file).
  /// It is then asked only for scans that will be kept.
  virtual bool waits() const noexcept { return false; }

  virtual ScanStamps scan_stamps() const noexcept { return ScanStamps::kConversion; }

  /// The device's clock at an instant of the machine's; of one that does not wait.  Hardware is stamped in
  /// the machine's own clock.  May be called from another thread while read() runs.
  virtual NodeTime node_time(MachineTime machine) const noexcept { return as_node_time(machine); }

  /// Before this instant, by its own clock, it is not to give anything; of one that does not wait.
  virtual NodeTime begins() const noexcept { return NodeTime::min(); }

  /// What the devices behind it count of their troubles; they live as long as the front end.
  virtual std::vector<const DeviceReport*> reports() const { return {}; }
};

}  // namespace roadbalance
