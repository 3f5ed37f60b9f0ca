#include "hil_tests/players/node_drive.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "common/config/section.hpp"

namespace roadbalance::test {
namespace {

constexpr std::size_t kRoom = 1024;

void check_scans(const std::vector<Scan>& scans, const std::string& name) {
  if (scans.size() < 2) throw ConfigError("drive of node " + name + ": holds no scans");
  for (std::size_t k = 1; k < scans.size(); ++k)
    if (scans[k].index != scans[k - 1].index + 1)
      throw ConfigError("drive of node " + name + ": has a gap after scan " +
                        std::to_string(scans[k - 1].index) +
                        ", but a converter never pauses; allowed: a drive "
                        "without gaps");
}

/// The converter's rate is that of the line through the first and the last scan: stamps of records are exact
/// to nanoseconds, those of a USB board's scans to some ten microseconds.
void measure_converter(NodeDrive& drive, double rate_hz) {
  const auto count = static_cast<double>(drive.scans.size() - 1);
  const double period_ns =
      static_cast<double>((drive.scans.back().time - drive.first_scan()).count()) / count;
  drive.converter_ppm = 1e6 * (1e9 / (period_ns * rate_hz) - 1.0);
  for (std::size_t k = 0; k < drive.scans.size(); ++k) {
    const auto even = NodeClock::duration(std::llround(static_cast<double>(k) * period_ns));
    const auto off = drive.scans[k].time - drive.first_scan() - even;
    drive.worst_stamp = std::max(drive.worst_stamp, std::chrono::abs(off));
  }
}

}  // namespace

NodeDrive read_drive(FrontEnd& source, const std::string& name, double rate_hz) {
  if (!source.waits())
    throw ConfigError("drive of node " + name +
                      ": it runs by the clock, but the player reads it ahead; allowed: "
                      "rate=max");
  NodeDrive drive;
  std::vector<Scan> scans(kRoom);
  std::vector<Edge> edges(kRoom);
  std::vector<SignalSample> signals(kRoom);
  for (ReadStatus status = ReadStatus::kOk; status == ReadStatus::kOk;) {
    const Read read = source.read(scans, edges, signals);
    drive.scans.insert(drive.scans.end(), scans.data(), scans.data() + read.scans);
    drive.edges.insert(drive.edges.end(), edges.data(), edges.data() + read.edges);
    drive.signals.insert(drive.signals.end(), signals.data(), signals.data() + read.signals);
    status = read.status;
    if (status == ReadStatus::kFailed) throw std::runtime_error("drive of node " + name + ": cannot be read");
  }
  check_scans(drive.scans, name);
  measure_converter(drive, rate_hz);
  std::ranges::stable_sort(drive.signals, {}, &SignalSample::time);
  return drive;
}

}  // namespace roadbalance::test
