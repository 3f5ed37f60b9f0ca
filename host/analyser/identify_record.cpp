#include "host/analyser/identify_record.hpp"

#include <optional>
#include <string>

#include "host/analyser/recorded_vehicle.hpp"
#include "host/analyser/refined_clocks.hpp"
#include "host/identify/doubt.hpp"
#include "host/identify/remarks.hpp"
#include "host/references/angle_again.hpp"

namespace roadbalance {

RecordedEstimate identify_record(const std::filesystem::path& folder, bool refine) {
  std::optional<RefinedClocks> clocks;
  if (refine) clocks.emplace(folder);
  std::optional<AngleAgain> angles;
  const auto vehicle = recorded_vehicle(folder);
  const auto teeth = refine ? AngleAgain::Teeth::kAgain : AngleAgain::Teeth::kAsLive;
  if (vehicle) angles.emplace(*vehicle, AngleAgain::WithoutMark::kNoAngle, teeth);
  if (angles && angles->wanted())
    read_recording(
        folder, [](const VehicleConfig&) {}, [&](const SealedBlock& block) { angles->learn(block); });

  std::optional<DriveEstimator> estimator;
  const RecordingDefects defects = read_recording(
      folder, [&](const VehicleConfig& recorded) { estimator.emplace(recorded); },
      [&](const SealedBlock& block) {
        if (clocks && block.kind == BlockKind::kScan)
          if (const auto fit = clocks->next(block.header)) estimator->consume(*fit);
        estimator->consume(angles ? angles->again(block) : block);
      },
      [&](const ClockFit& fit) {
        if (!clocks || !clocks->knows(fit.node, fit.epoch)) estimator->consume(fit);
      });
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
  return {estimate, obstacle, remarks(estimate.identification, estimate.balance), defects};
}

}  // namespace roadbalance
