#pragma once

#include <span>
#include <vector>

#include "common/frontend/front_end.hpp"

namespace roadbalance {

/// The result of one call of a side source.
struct SideRead {
  std::size_t edges = 0;
  std::size_t signals = 0;
  /// Everything stamped before this instant has been handed over, by this call or an earlier one.  For a
  /// device that is gone: the present, for nothing will come.
  NodeTime complete_until{};
};

/// A device that gives no scans but what belongs beside them: encoder edges, signals of the car.
///
/// Its own thread fetches from the kernel as things come, so that nothing overflows there, and keeps them
/// until take().  Stamps are of the machine's clock.
class SideSource {
 public:
  SideSource() = default;
  SideSource(const SideSource&) = delete;
  SideSource& operator=(const SideSource&) = delete;
  virtual ~SideSource() = default;

  /// Everything since the last call, each in order of time, up to the spans' sizes; the rest comes next.
  /// Called from one thread.  Never allocates, waits or blocks.
  virtual SideRead take(std::span<Edge> edges, std::span<SignalSample> signals) noexcept = 0;

  /// As FrontEnd::reports().
  virtual std::vector<const DeviceReport*> reports() const = 0;
};

}  // namespace roadbalance
