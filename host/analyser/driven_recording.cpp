#include "host/analyser/driven_recording.hpp"

#include "host/analyser/read_with_angles.hpp"

namespace roadbalance {

DrivenRecording driven_recording(const std::filesystem::path& folder, bool refine,
                                 const std::stop_token& stop,
                                 const std::function<void(const SealedBlock&)>& see) {
  DrivenRecording drive;
  std::optional<AngleAgain> angles;
  drive.defects = read_with_angles(folder, refine, angles,
                                   {[&](const VehicleConfig& recorded) {
                                      drive.estimator =
                                          std::make_unique<DriveEstimator>(drive.vehicle.emplace(recorded));
                                    },
                                    [&](const SealedBlock& block) {
                                      if (stop.stop_requested()) throw Interrupted();
                                      if (see) see(block);
                                      drive.estimator->consume(block);
                                    },
                                    [&](const ClockFit& fit) { drive.estimator->consume(fit); }});
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (const auto quality = angles ? angles->quality(wheel) : std::nullopt) {
      const auto w = static_cast<std::size_t>(wheel);
      drive.common_sigma_rad[w] = quality->common_sigma_rad;
      if (const std::string why = quality->contradiction(); !why.empty())
        drive.contradictions +=
            (drive.contradictions.empty() ? "" : "; ") + std::string(kWheelNames[w]) + ": " + why;
    }
  return drive;
}

}  // namespace roadbalance
