#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/decimating_filter.hpp"
#include "host/analysis/identify/signals.hpp"

namespace roadbalance {

/// Samples of the nodes for one of identification.
/// @throws ConfigError if identification needs more than the nodes take
int decimation_factor(const VehicleConfig& vehicle);

/// One sample at the identification rate.
struct IdentificationSample {
  SignalVector signals;
  Eigen::VectorXd readings{};  ///< as SignalRun's
  bool restart = false;        ///< samples are missing before it
  bool spoiled = false;        ///< nor are those before them good, since the last restart
  std::int64_t time_ns = 0;
  std::optional<Eigen::Vector4d> road_m{};  ///< nothing: not measured
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
  DecimatingFilter signals_, road_;
  std::optional<DecimatingFilter> readings_;  ///< once their number is there
  bool restart_ = true, spoiled_ = false;
  Emit emit_;
};

}  // namespace roadbalance
