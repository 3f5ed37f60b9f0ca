#pragma once

#include <memory>
#include <optional>

#include "host/excerpt/epoch_sink.hpp"
#include "host/excerpt/row_decimator.hpp"

namespace roadbalance {

/// Leaves every factor-th scan of what it is given to another sink; edges and signals as they are.
///
/// The scans that are left lie on one grid from the first one on, whatever is missing between.  No filter
/// reaches across a gap, so that each grows by what the filter reaches to both sides and keeps its cause, and
/// as much is left out at the beginning and at the end.
class ReducingSink final : public EpochSink {
 public:
  ReducingSink(int factor, std::unique_ptr<EpochSink> to);

  void scans(const ScanBlock& block) override;
  void gap(std::int64_t scans, std::int64_t time_ns, GapCause cause) override;
  void edges(std::span<const Edge> edges) override { to_->edges(edges); }
  void signals(std::span<const SignalSample> samples) override { to_->signals(samples); }
  void end(Ending ending) override;

 private:
  void add(const RowDecimator::Reduced& reduced, std::int64_t period_ps);
  void put_rows();

  const int factor_;
  const std::unique_ptr<EpochSink> to_;
  RowDecimator decimator_;
  std::int64_t index_ = 0;       ///< of the next scan that comes
  std::int64_t next_ = 0;        ///< of the next one that is left
  std::int64_t next_ns_ = 0;     ///< its instant
  bool begun_ = false;           ///< one was left
  ScanBlock block_;              ///< of those that are left, filling
  std::optional<GapCause> gap_;  ///< since the one left last
};

}  // namespace roadbalance
