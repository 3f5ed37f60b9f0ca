#include "host/analyser/identify_record.hpp"

#include <optional>

namespace roadbalance {

RecordedEstimate identify_record(const std::filesystem::path& folder) {
  std::optional<DriveEstimator> estimator;
  const RecordingDefects defects = read_recording(
      folder, [&](const VehicleConfig& vehicle) { estimator.emplace(vehicle); },
      [&](const SealedBlock& block) { estimator->consume(block); });
  return {estimator->estimate(), estimator->obstacle(), defects};
}

}  // namespace roadbalance
