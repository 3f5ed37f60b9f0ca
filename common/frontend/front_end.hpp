#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/types/clocks.hpp"
#include "common/types/device_report.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {

enum class ReadStatus {
  kOk,
  kEnd,     ///< the device has no more, e.g. a recording is over; what was returned still counts
  kFailed,  ///< the device is gone; what was returned still counts
};

struct Read {
  std::size_t scans = 0;    ///< how many of the given scans were filled
  std::size_t edges = 0;    ///< how many of the given edges were filled
  std::size_t signals = 0;  ///< how many of the given signal samples were filled
  ReadStatus status = ReadStatus::kOk;
};

/// The meaning of a scan's time.
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

  /// True if the device loses nothing while it is not read (a simulation faster than real time, a file). It
  /// is then asked only for scans that will be kept.
  virtual bool waits() const noexcept { return false; }

  virtual ScanStamps scan_stamps() const noexcept { return ScanStamps::kConversion; }

  /// The device's clock at an instant of the machine's; of one that does not wait.  Hardware is stamped in
  /// the machine's own clock.  May be called from another thread while read() runs.
  virtual NodeTime node_time(MachineTime machine) const noexcept { return as_node_time(machine); }

  /// Before this instant, by its own clock, it is not to give anything; of one that does not wait.
  virtual NodeTime begins() const noexcept { return NodeTime::min(); }

  /// The counters of troubles of the devices behind it; they live as long as the front end.
  virtual std::vector<const DeviceReport*> reports() const { return {}; }
};

}  // namespace roadbalance
