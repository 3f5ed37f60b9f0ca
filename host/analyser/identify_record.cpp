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

RecordedEstimate recorded_estimate(DriveEstimate estimate, const DriveForces& forces,
                                   const VehicleConfig& vehicle,
                                   const std::array<double, kWheels>& common_sigma_rad) {
  for (std::size_t w = 0; w < kWheels; ++w)
    // What is wrong with a wheel's angle all through the drive is wrong with the place of its unbalance.
    if (estimate.balance[w].state == Unknown::kNone && common_sigma_rad[w] > 0.0)
      add_doubt(estimate.balance[w], 0.0, common_sigma_rad[w] * common_sigma_rad[w]);
  const auto compensation = compensate_all(estimate.balance, forces, vehicle);
  std::optional<OverallPlan> overall;
  if (!forces.speed.empty()) overall = plan_overall(forces, vehicle, compensation);
  return {estimate, {}, remarks(estimate.identification, estimate.balance), {}, compensation, overall};
}

RecordedEstimate identify_record(const std::filesystem::path& folder, bool refine,
                                 const std::stop_token& stop) {
  const DrivenRecording drive = driven_recording(folder, refine, stop);
  const DriveEstimate estimate = drive.estimator->estimate();
  RecordedEstimate found =
      recorded_estimate(estimate, drive.estimator->forces(), *drive.vehicle, drive.common_sigma_rad);
  found.obstacle = drive.estimator->obstacle();
  if (!drive.contradictions.empty())
    found.obstacle += (found.obstacle.empty() ? "" : "; ") + drive.contradictions;
  found.defects = drive.defects;
  return found;
}

}  // namespace roadbalance
