#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/analyser/read_recording.hpp"
#include "host/orders/wheel_orders.hpp"

namespace roadbalance {

struct WantedOrders {
  std::optional<std::string> wheel;    ///< nothing: every wheel that has an encoder
  std::optional<std::string> channel;  ///< nothing: every acceleration of the node that reads the encoder
  std::vector<double> order{1.0, 2.0};
};

struct RecordOrders {
  std::vector<std::unique_ptr<WheelOrders>> wheel;  ///< at least one
  RecordingDefects defects;
};

/// Orders in a finished recording.
/// @throws ConfigError naming a wheel, channel or order that cannot be analysed, and what can; else as
///         read_recording
RecordOrders orders_of_record(const std::filesystem::path& folder, const WantedOrders& wanted);

}  // namespace roadbalance
