#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/control_messages.hpp"
#include "common/config/vehicle_config.hpp"
#include "tools/doctor/finding.hpp"

namespace roadbalance {

/// The nodes and recorders that are heard on a bus while this listens.
class RollCall {
 public:
  /// From now on what comes waits to be heard.
  /// @throws std::runtime_error naming the URL if there is no bus
  explicit RollCall(const std::string& url);

  void listen(std::chrono::milliseconds duration);

  /// Their numbers.
  std::set<std::int32_t> nodes() const;
  /// One if all is well, else one for each thing that is not.
  /// @param vehicle  whose nodes are to be there; nullptr: any will do
  /// @param file     that it was read from
  std::vector<Finding> findings(const VehicleConfig* vehicle, const std::string& file) const;

 private:
  struct Node {
    std::set<std::int64_t> epochs{};  ///< at most kMostEpochs
    std::int64_t newest = 0;          ///< of these, heard last
    bool is_two = false;
    std::uint32_t vehicle_crc32c = 0;
  };
  static constexpr std::size_t kMostEpochs = 16;
  void take(const Heartbeat& beat);
  void add_strangers(const VehicleConfig& vehicle, const std::string& file,
                     std::vector<Finding>& findings) const;
  void add_recorders(const std::string& file, std::vector<Finding>& findings) const;

  const std::string url_;
  Bus bus_;
  std::map<std::int32_t, Node> nodes_;
  std::set<std::int32_t> of_other_versions_;
  std::set<std::int64_t> recorders_;
};

}  // namespace roadbalance
