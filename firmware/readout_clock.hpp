#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "common/frontend/front_end.hpp"

namespace roadbalance {

/// Gives scans that were stamped when they were read the times of their conversion; for front ends with
/// ScanStamps::kReadOut.
///
/// The converter's clock is even, reading is only ever late: conversion lies on a line of time over scan
/// index below all stamps.  In each second the earliest stamp against the nominal period counts; the line is
/// the edge of the lower convex hull of the last 32 seconds over their middle (S. Moon, P. Skelly, D.
/// Towsley, Estimation and removal of clock skew, INFOCOM 1999), which neither bunches nor hiccups of reading
/// pull. The shortest delay of reading is not seen and stays in the times.  Where the line moves, the times
/// follow by at most 0.1 % of the time that passes, and do not step; after an absence of the device, whose
/// clock or count may be another since, and after a stamp a second off the line, which no delay explains,
/// everything begins anew.
///
/// Unlike fit_sample_clock of the CSV import it has only the past.  Never allocates.
class ReadoutClock {
 public:
  /// @param rate_hz  nominal; the converter's may differ by 0.1 %
  explicit ReadoutClock(double rate_hz);

  /// Replaces the times; scans as they come from the device.
  void correct(std::span<Scan> scans) noexcept;

 private:
  /// How much later than on the nominal line through the first stamp; seconds since then.
  struct Point {
    double at_s, late_s;
  };
  static constexpr std::size_t kPoints = 32;
  static constexpr double kBin_s = 1.0;

  void restart(const Scan& scan) noexcept;
  void add(Point point) noexcept;
  void fit() noexcept;
  double line_s(double at_s) const noexcept { return late_s_ + slope_ * at_s; }

  const double period_s_;
  bool started_ = false;
  std::int64_t first_index_ = 0;
  NodeTime first_time_{};
  std::array<Point, kPoints> point_{};  ///< ascending, of finished bins
  std::size_t points_ = 0;
  Point bin_{};  ///< earliest of the present bin
  double bin_end_s_ = 0.0;
  double late_s_ = 0.0, slope_ = 0.0;  ///< the line
  double shown_s_ = 0.0;               ///< where the times are, following the line
  double shown_at_s_ = 0.0;
};

/// A front end whose scans bear the times of their conversion, whatever the one inside stamps.
class ConversionTimes final : public FrontEnd {
 public:
  /// @param rate_hz  nominal
  ConversionTimes(FrontEnd& inside, double rate_hz) : inside_(inside), clock_(rate_hz) {}

  Read read(std::span<Scan> scans, std::span<Edge> edges, std::span<SignalSample> signals) noexcept override {
    const Read read = inside_.read(scans, edges, signals);
    if (inside_.scan_stamps() == ScanStamps::kReadOut) clock_.correct(scans.first(read.scans));
    return read;
  }
  bool waits() const noexcept override { return inside_.waits(); }
  NodeTime node_time(MachineTime machine) const noexcept override { return inside_.node_time(machine); }
  NodeTime begins() const noexcept override { return inside_.begins(); }
  std::vector<const DeviceReport*> reports() const override { return inside_.reports(); }

 private:
  FrontEnd& inside_;
  ReadoutClock clock_;
};

}  // namespace roadbalance
