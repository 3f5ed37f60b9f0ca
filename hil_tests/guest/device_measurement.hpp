#pragma once

#include <string>
#include <vector>

#include "common/types/device_report.hpp"
#include "hil_tests/measurement.hpp"

namespace roadbalance::test {

/// rb-node on devices of the guest, recorded.
class DeviceMeasurement : public Measurement {
 protected:
  /// The demonstration's vehicle, whose front node is wired so.
  /// @param wiring  keys and tables of [[node]]
  void wire(const std::string& wiring, int rate_hz) const;
  /// The front node on devices of these addresses.
  Program device_node(const std::vector<std::string>& devices) const;

  /// Counters of the node, by its heartbeats.
  std::int64_t count_of(DeviceCounter counter) const;
  bool counted(DeviceCounter counter, std::int64_t times);

  /// Output of the node.
  std::string said() const;
  /// The node printed it of this device, and the record keeps it.
  void expect_said(const std::string& device, const std::vector<std::string>& sentences) const;
  /// The one epoch's gaps; all else of the record must be sound.
  std::vector<VerifiedGap> gaps() const;

  const std::string vehicle_file = work.path() / "vehicle.toml";
  const std::string said_file = work.path() / "said";
};

}  // namespace roadbalance::test
