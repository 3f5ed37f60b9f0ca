#include "host/analysis/identify/decimate.hpp"

#include <cmath>
#include <utility>

#include "common/config/section.hpp"
#include "common/dsp/decimation.hpp"

namespace roadbalance {

int decimation_factor(const VehicleConfig& vehicle) {
  const double factor = vehicle.node.front().rate_hz / vehicle.drive.identification_rate_hz;
  if (factor < 1.0)
    throw ConfigError("vehicle " + vehicle.name + ": identification_rate_hz is above the nodes' rate_hz");
  return static_cast<int>(std::lround(factor));
}

Decimator::Decimator(int factor, Emit emit)
    : factor_(factor),
      signals_(kSignals, factor, decimation_taps(factor)),
      road_(kWheels, factor, decimation_taps(factor)),
      emit_(std::move(emit)) {}

void Decimator::consume(const SignalRun& run) {
  if (run.restart) {
    signals_.restart(run.first_index);
    restart_ = true;
    spoiled_ = spoiled_ || run.spoiled;
    readings_.reset();
  }
  const bool has_readings = run.readings.cols() > 0;
  if (has_readings && !readings_) {
    readings_.emplace(run.readings.rows(), factor_, decimation_taps(factor_));
    readings_->restart(run.first_index);
  }
  const bool measured = run.road_m.cols() > 0;
  if (run.restart || !measured) road_.restart(run.first_index + (measured ? 0 : run.samples.cols()));
  for (Eigen::Index i = 0; i < run.samples.cols(); ++i) {
    const bool has_road = measured && road_.add(run.road_m.col(i));
    if (has_readings) readings_->add(run.readings.col(i));
    if (!signals_.add(run.samples.col(i))) continue;
    IdentificationSample sample{.signals = signals_.output(),
                                .restart = std::exchange(restart_, false),
                                .spoiled = std::exchange(spoiled_, false),
                                .time_ns = run.time_ns};
    if (has_readings) sample.readings = readings_->output();
    if (has_road) sample.road_m = road_.output();
    emit_(sample);
  }
}

}  // namespace roadbalance
