#pragma once

#include <cstdint>
#include <functional>

#include <Eigen/Core>

#include "host/identify/signals.hpp"

namespace roadbalance {

/// One sample at the identification rate.
struct IdentificationSample {
  SignalVector signals;
  bool restart = false;  ///< samples are missing before it
  std::int64_t time_ns = 0;
};

/// Brings all signals to the identification rate with one linear-phase low-pass, so that the relations
/// between them stay as they are.
///
/// The low-pass is decimation_taps.  Output samples lie on grid indices that are multiples of the factor,
/// whatever was missing before.
class Decimator {
 public:
  using Emit = std::function<void(const IdentificationSample&)>;

  /// @param factor  grid rate / identification rate, >= 1
  Decimator(int factor, Emit emit);

  void consume(const SignalRun& run);

 private:
  int factor_;
  Eigen::VectorXd taps_;
  SignalMatrix history_;  // the last taps_.size() samples, column filled_ - 1 the newest
  Eigen::Index filled_ = 0;
  bool restart_ = true;
  Emit emit_;
};

}  // namespace roadbalance
