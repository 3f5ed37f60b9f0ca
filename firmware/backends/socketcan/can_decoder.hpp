#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/dbc/dbc.hpp"
#include "common/types/scan.hpp"
#include "firmware/backends/socketcan/can_socket.hpp"

namespace roadbalance {

/// Frames of a CAN interface to the signals that vehicle.toml asks for.
class CanDecoder {
 public:
  /// @param dbc  what describes the frames; may be gone afterwards
  /// @throws ConfigError as find_wanted(), and for more than kMostOfOneFrame of one message
  CanDecoder(const CanConfig& can, const VehicleConfig& vehicle, const Dbc& dbc);
  /// For an interface without signals.
  CanDecoder() = default;

  /// A frame gives at most so many samples, the room that a reader has to have.
  static constexpr std::size_t kMostOfOneFrame = 64;

  std::vector<CanId> ids() const;
  /// A message is longer than classic CAN carries.
  bool needs_fd() const;

  /// Nothing from a frame that is not asked for.  Never allocates.
  /// @param report  counts a frame that is too short, or a value of it no measurement; it gives what else it
  /// has
  /// @return how many samples it gave
  std::size_t decode(const CanFrame& frame, NodeTime time, std::span<SignalSample> samples,
                     DeviceReport& report) const noexcept;

 private:
  struct Wanted {
    std::size_t in_message;  ///< place of the signal there
    std::uint16_t number;    ///< SignalSample::signal
    double factor;           ///< from the DBC file's unit to the quantity's
  };
  struct Message {
    CanId id;
    DbcMessage description;
    std::vector<Wanted> wanted;
  };
  Message& message_of(const DbcMessage& description);

  std::vector<Message> messages_;  // few
};

}  // namespace roadbalance
