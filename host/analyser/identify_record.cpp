#include "host/analyser/identify_record.hpp"

#include <functional>
#include <optional>
#include <string>

#include "common/config/section.hpp"
#include "host/analyser/read_with_angles.hpp"
#include "host/identify/assemble.hpp"
#include "host/identify/decimate.hpp"
#include "host/identify/doubt.hpp"
#include "host/identify/remarks.hpp"
#include "host/identify/stretch_collector.hpp"

namespace roadbalance {

RecordingDefects collect_stretches(const std::filesystem::path& folder, bool refine,
                                   const std::function<void(const Stretch&)>& emit) {
  std::optional<AngleAgain> angles;
  std::optional<StretchCollector> stretches;
  std::optional<Decimator> decimator;
  std::optional<Assembler> assembler;
  const auto begin = [&](const VehicleConfig& vehicle) {
    stretches.emplace(vehicle, emit);
    decimator.emplace(decimation_factor(vehicle),
                      [&](const IdentificationSample& sample) { stretches->consume(sample); });
    assembler.emplace(vehicle, [&](const SignalRun& run) { decimator->consume(run); });
  };
  const RecordingDefects defects =
      read_with_angles(folder, refine, angles,
                       {begin, [&](const SealedBlock& block) { assembler->consume(block); },
                        [&](const ClockFit& fit) { assembler->consume(fit); }});
  if (const std::string why = assembler->no_common_time(); !why.empty()) throw ConfigError(why);
  stretches->finish();
  return defects;
}

RecordedEstimate identify_record(const std::filesystem::path& folder, bool refine,
                                 const std::stop_token& stop) {
  std::optional<AngleAgain> angles;
  std::optional<DriveEstimator> estimator;
  std::optional<VehicleConfig> vehicle;
  const RecordingDefects defects =
      read_with_angles(folder, refine, angles,
                       {[&](const VehicleConfig& recorded) { estimator.emplace(vehicle.emplace(recorded)); },
                        [&](const SealedBlock& block) {
                          if (stop.stop_requested()) throw Interrupted();
                          estimator->consume(block);
                        },
                        [&](const ClockFit& fit) { estimator->consume(fit); }});
  DriveEstimate estimate = estimator->estimate();
  std::string obstacle = estimator->obstacle();
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (const auto quality = angles ? angles->quality(wheel) : std::nullopt) {
      // What is wrong with a wheel's angle all through the drive is wrong with the place of its unbalance.
      Balance& balance = estimate.balance[static_cast<std::size_t>(wheel)];
      const double sigma_rad = quality->common_sigma_rad;
      if (balance.state == Unknown::kNone) add_doubt(balance, 0.0, sigma_rad * sigma_rad);
      if (const std::string why = quality->contradiction(); !why.empty())
        obstacle += (obstacle.empty() ? "" : "; ") +
                    std::string(kWheelNames[static_cast<std::size_t>(wheel)]) + ": " + why;
    }
  const auto compensation = compensate_all(estimate.balance, estimator->forces(), *vehicle);
  std::optional<OverallPlan> overall;
  if (const DriveForces& forces = estimator->forces(); !forces.speed.empty())
    overall = plan_overall(forces, *vehicle, compensation);
  return {estimate, obstacle,     remarks(estimate.identification, estimate.balance),
          defects,  compensation, overall};
}

}  // namespace roadbalance
