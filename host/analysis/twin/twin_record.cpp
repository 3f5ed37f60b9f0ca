#include "host/analysis/twin/twin_record.hpp"

#include "host/analysis/angle/read_with_angles.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/analysis/twin/sensor_samples.hpp"
#include "host/recording/recorded_vehicle.hpp"

namespace roadbalance {
namespace {

/// The twin, its account and what feeds it.
class Run {
 public:
  Run(const TwinRequest& request, const VehicleConfig& vehicle, const RecordedTwin& of,
      const OnTwinSample& on_sample)
      : request_(request),
        on_sample_(on_sample),
        twin_(of.channels, of.car, SensorSamples::rate_hz(vehicle)),
        shares_(of.channels, SensorSamples::rate_hz(vehicle), 0.0),
        samples_(vehicle, of.channels, [this](const SensorSample& sample) { take(sample); }) {}

  SensorSamples& samples() { return samples_; }
  const Twin& twin() const { return twin_; }
  const TwinShares& shares() const { return shares_; }

 private:
  void take(const SensorSample& sample) {
    if (!first_ns_) first_ns_ = sample.time_ns;
    const TwinSample* const predicted = twin_.consume(sample);
    if (!predicted) return;
    const double at_s = 1e-9 * static_cast<double>(predicted->time_ns - *first_ns_);
    if (at_s < request_.from_s || at_s >= request_.to_s) return;
    shares_.add(*predicted);
    if (on_sample_) on_sample_(at_s, *predicted);
  }

  const TwinRequest& request_;
  const OnTwinSample& on_sample_;
  Twin twin_;
  TwinShares shares_;
  SensorSamples samples_;
  std::optional<std::int64_t> first_ns_;
};

}  // namespace

RecordedTwin twin_of_record(const TwinRequest& request,
                            const std::function<void(const VehicleConfig&, const TwinChannels&)>& begin,
                            const OnTwinSample& on_sample, const std::stop_token& stop) {
  RecordedTwin result{};
  std::optional<RecordedEstimate> estimate;
  if (!request.car) {
    estimate = identify_record(request.folder, request.refine, stop);
    result.refusal = estimate->refusal;
  }
  std::optional<AngleReprocessor> angles;
  std::optional<Run> run;
  const auto start = [&](const VehicleConfig& vehicle) {
    result.vehicle = vehicle;
    result.channels = TwinChannels::of(vehicle);
    result.car = request.car ? *request.car
                             : TwinCar::estimated(vehicle, estimate->estimate.identification,
                                                  estimate->estimate.balance);
    if (begin) begin(vehicle, result.channels);
    run.emplace(request, vehicle, result, on_sample);
  };
  result.defects = read_with_angles(request.folder, request.refine, angles,
                                    {start,
                                     [&](const SealedBlock& block) {
                                       if (stop.stop_requested()) throw Interrupted();
                                       run->samples().consume(block);
                                     },
                                     [&](const ClockFit& fit) { run->samples().consume(fit); }});
  if (const std::string why = run->samples().no_common_time(); !why.empty())
    result.refusal += (result.refusal.empty() ? "" : "; ") + why;
  result.total = run->shares().total();
  result.seconds = run->shares().seconds();
  result.behind_s = run->twin().behind_s();
  result.settling_s = run->twin().settling_s();
  return result;
}

}  // namespace roadbalance
