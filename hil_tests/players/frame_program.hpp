#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/dbc/can_frame.hpp"
#include "common/dbc/dbc.hpp"
#include "hil_tests/players/node_drive.hpp"

namespace roadbalance::test {

struct DriveFrame {
  NodeTime time{};
  std::size_t interface = 0;  ///< in the order of FrameProgram::interfaces()
  CanFrame frame;
};

/// The signals of a drive as the frames that the car would send: each message whenever one of its signals has
/// a sample; its other signals keep their last values, at first 0.
///
/// Samples of one message within 100 us are of one frame, also those of several nodes that listened to the
/// same bus: on a real one two frames of 8 bytes cannot come that close (ISO 11898-1, 500 kbit/s).
class FrameProgram {
 public:
  /// Samples of one node; nodes that name the same interface are on the same bus.
  /// @throws ConfigError as find_wanted(), or naming a message that is multiplexed
  void add(const VehicleConfig& vehicle, const NodeConfig& node, const NodeDrive& drive);

  const std::vector<std::string>& interfaces() const { return interfaces_; }
  /// In order of time.
  /// @throws ConfigError naming a signal with a value beyond its bits
  std::vector<DriveFrame> take();

 private:
  struct Message {
    std::size_t interface;
    DbcMessage description;
  };
  struct SignalEncoding {
    std::size_t message;  ///< in messages_
    CanSignal place;
    double factor;  ///< from the file's unit to the quantity's
    std::string name;
  };
  struct Value {
    NodeTime time;
    std::size_t encoding;  ///< in encodings_
    double value;          ///< in the file's unit
  };
  std::size_t interface_of(const std::string& name);
  std::size_t message_of(std::size_t interface, const DbcMessage& description);

  std::vector<std::string> interfaces_;
  std::vector<Message> messages_;
  std::vector<SignalEncoding> encodings_;
  std::vector<Value> values_;
};

}  // namespace roadbalance::test
