#include "host/analyser/identify_record.hpp"

#include <optional>

#include "host/analyser/read_recording.hpp"

namespace roadbalance {

RecordedEstimate identify_record(const std::filesystem::path& folder) {
  std::optional<DriveEstimator> estimator;
  read_recording(
      folder, [&](const VehicleConfig& vehicle) { estimator.emplace(vehicle); },
      [&](const SealedBlock& block) { estimator->consume(block); });
  return {estimator->estimate(), estimator->obstacle()};
}

}  // namespace roadbalance
