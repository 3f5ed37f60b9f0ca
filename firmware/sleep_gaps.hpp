#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/frontend/front_end.hpp"

namespace roadbalance {

/// A front end whose scans show a sleep of this computer: the first one behind it is numbered by the time
/// that has passed, and flagged.  A device does not count what it does not convert.
///
/// The stamps of a device show a sleep as a jump of half its length or more; those that were waiting to be
/// read come before it.  Never allocates.
class SleepGaps final : public FrontEnd {
 public:
  /// @param slept  so far, by the machine's clock
  SleepGaps(FrontEnd& inside, double rate_hz,
            std::function<MachineClock::duration()> slept = &MachineClock::slept);

  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> signals) noexcept override;
  bool waits() const noexcept override { return inside_.waits(); }
  NodeTime node_time(MachineTime machine) const noexcept override { return inside_.node_time(machine); }
  NodeTime begins() const noexcept override { return inside_.begins(); }
  std::vector<const DeviceReport*> reports() const override { return inside_.reports(); }

 private:
  void correct(Scan& scan) noexcept;

  FrontEnd& inside_;
  const double rate_hz_;
  const std::function<MachineClock::duration()> slept_so_far_;
  MachineClock::duration slept_;      ///< when it was asked last
  MachineClock::duration pending_{};  ///< of sleeps that no jump of the stamps has shown yet
  bool has_last_ = false;
  std::int64_t last_index_ = 0;  ///< by the device
  NodeTime last_time_{}, give_up_at_{};
  std::int64_t behind_ = 0;  ///< what is to be added to the device's numbers
};

}  // namespace roadbalance
