#include "host/identify/decimate.hpp"

#include <cmath>
#include <utility>

#include "common/config/section.hpp"
#include "common/dsp/decimation.hpp"
#include "common/dsp/weighted_sum.hpp"

namespace roadbalance {

int decimation_factor(const VehicleConfig& vehicle) {
  const double factor = vehicle.node.front().rate_hz / vehicle.drive.identification_rate_hz;
  if (factor < 1.0)
    throw ConfigError("vehicle " + vehicle.name + ": identification_rate_hz is above the nodes' rate_hz");
  return static_cast<int>(std::lround(factor));
}

Decimator::Decimator(int factor, Emit emit)
    : factor_(factor),
      taps_(decimation_taps(factor)),
      history_(SignalMatrix::Zero(kSignals, 8 * taps_.size())),
      road_(RoadMatrix::Zero(kWheels, history_.cols())),
      emit_(std::move(emit)) {}

void Decimator::consume(const SignalRun& run) {
  if (run.restart) {
    filled_ = 0;
    restart_ = true;
  }
  const Eigen::Index n = taps_.size();
  const bool measured = run.road_m.cols() > 0;
  for (Eigen::Index i = 0; i < run.samples.cols(); ++i) {
    if (filled_ == history_.cols()) {
      history_.leftCols(n - 1) = history_.rightCols(n - 1).eval();
      road_.leftCols(n - 1) = road_.rightCols(n - 1).eval();
      filled_ = n - 1;
    }
    if (measured) road_.col(filled_) = run.road_m.col(i);
    history_.col(filled_++) = run.samples.col(i);
    const std::int64_t centre = run.first_index + i - (n - 1) / 2;
    if (filled_ < n || centre % factor_ != 0) continue;
    IdentificationSample sample;
    weighted_sum(history_.middleCols(filled_ - n, n), taps_, sample.signals);
    if (measured) weighted_sum(road_.middleCols(filled_ - n, n), taps_, sample.road_m.emplace());
    sample.restart = std::exchange(restart_, false);
    sample.time_ns = run.time_ns;
    emit_(sample);
  }
}

}  // namespace roadbalance
