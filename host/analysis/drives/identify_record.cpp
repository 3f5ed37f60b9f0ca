#include "host/analysis/drives/identify_record.hpp"

#include <functional>
#include <optional>
#include <set>
#include <string>

#include "common/bus/notes.hpp"
#include "common/config/section.hpp"
#include "host/analysis/angle/read_with_angles.hpp"
#include "host/analysis/identify/assemble.hpp"
#include "host/analysis/identify/decimate.hpp"
#include "host/analysis/identify/diagnostics.hpp"
#include "host/analysis/identify/extra_variance.hpp"
#include "host/analysis/identify/stretch_collector.hpp"
#include "host/recording/verify/verify_presence.hpp"

namespace roadbalance {

DrivenRecording driven_recording(const std::filesystem::path& folder, bool refine,
                                 const std::stop_token& stop,
                                 const std::function<void(const SealedBlock&)>& see) {
  DrivenRecording drive;
  std::set<std::int32_t> measured, ended;  // nodes: any epoch, the last one
  PresenceCheck presence;
  std::optional<AngleReprocessor> angles;
  drive.defects = read_with_angles(
      folder, refine, angles,
      {[&](const VehicleConfig& recorded) {
         drive.estimator = std::make_unique<DriveEstimator>(drive.vehicle.emplace(recorded));
       },
       [&](const SealedBlock& block) {
         if (stop.stop_requested()) throw Interrupted();
         if (see) see(block);
         if (block.kind == BlockKind::kScan) measured.insert(block.header.node);
         block.kind == BlockKind::kEnd ? (void)ended.insert(block.header.node)
                                       : (void)ended.erase(block.header.node);
         drive.estimator->consume(block);
       },
       [&](const ClockFit& fit) { drive.estimator->consume(fit); },
       [&](const LogEvent& event) {
         presence.take_time(event.timestamp_us);
         if (const auto note = event.channel == kNoteChannel ? decode_note(event.data) : std::nullopt)
           presence.take(*note);
       }});
  const auto object = [&drive](const std::string& why) {
    drive.contradictions += (drive.contradictions.empty() ? "" : "; ") + why;
  };
  for (const NodeConfig& node : drive.vehicle->node)
    if (!measured.contains(node.id))
      object("node " + std::to_string(node.id) + " (" + node.name +
             ") has no sample in this recording, and every node of its vehicle.toml is needed");
  // Where one is absent the others' samples are of no use, which no other sentence says.
  for (const Absence& absence : presence.absences(ended))
    if (measured.contains(absence.node)) object(presence.sentence(absence));
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (const auto quality = angles ? angles->quality(wheel) : std::nullopt) {
      const auto w = static_cast<std::size_t>(wheel);
      drive.common_sigma_rad[w] = quality->common_sigma_rad;
      if (const std::string why = quality->contradiction(); !why.empty())
        object(std::string(kWheelNames[w]) + ": " + why);
    }
  return drive;
}

RecordingDefects collect_stretches(const std::filesystem::path& folder, bool refine,
                                   const std::function<void(const Stretch&)>& emit) {
  std::optional<AngleReprocessor> angles;
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
    // A constant error of a wheel's angle all through the drive is an error of the place of its unbalance.
    if (estimate.balance[w].state == Unknown::kNone && common_sigma_rad[w] > 0.0)
      add_variance(estimate.balance[w], 0.0, common_sigma_rad[w] * common_sigma_rad[w]);
  const auto compensation = compensate_all(estimate.balance, forces, vehicle);
  std::optional<OverallPlan> overall;
  if (!forces.speed.empty()) overall = plan_overall(forces, vehicle, compensation);
  return {estimate, {}, diagnostics(estimate.balance), {}, compensation, overall};
}

RecordedEstimate identify_record(const std::filesystem::path& folder, bool refine,
                                 const std::stop_token& stop) {
  const DrivenRecording drive = driven_recording(folder, refine, stop);
  const DriveEstimate estimate = drive.estimator->estimate();
  RecordedEstimate found =
      recorded_estimate(estimate, drive.estimator->forces(), *drive.vehicle, drive.common_sigma_rad);
  found.refusal = drive.estimator->refusal();
  for (const std::string& sentence : drive.estimator->remarks()) found.diagnostics.push_back(sentence);
  if (estimate.identification.sections > 0)  // else the refusal names them
    for (std::string& sentence : drive.estimator->clipped()) found.diagnostics.push_back(std::move(sentence));
  if (!drive.contradictions.empty())
    found.refusal += (found.refusal.empty() ? "" : "; ") + drive.contradictions;
  found.defects = drive.defects;
  return found;
}

}  // namespace roadbalance
