#include "host/analyser/identify_record.hpp"

#include <optional>

#include "host/analyser/refined_clocks.hpp"

namespace roadbalance {

RecordedEstimate identify_record(const std::filesystem::path& folder, bool refine) {
  std::optional<RefinedClocks> clocks;
  if (refine) clocks.emplace(folder);
  std::optional<DriveEstimator> estimator;
  const RecordingDefects defects = read_recording(
      folder, [&](const VehicleConfig& vehicle) { estimator.emplace(vehicle); },
      [&](const SealedBlock& block) {
        if (clocks && block.kind == BlockKind::kScan)
          if (const auto fit = clocks->next(block.header)) estimator->consume(*fit);
        estimator->consume(block);
      },
      [&](const ClockFit& fit) {
        if (!clocks || !clocks->knows(fit.node, fit.epoch)) estimator->consume(fit);
      });
  return {estimator->estimate(), estimator->obstacle(), defects};
}

}  // namespace roadbalance
