#include "host/analyser/read_with_angles.hpp"

#include "host/analyser/recorded_vehicle.hpp"
#include "host/analyser/refined_clocks.hpp"

namespace roadbalance {

RecordingDefects read_with_angles(const std::filesystem::path& folder, bool refine,
                                  std::optional<AngleAgain>& angles, const BlockReader& reader) {
  std::optional<RefinedClocks> clocks;
  if (refine) clocks.emplace(folder);
  const auto vehicle = recorded_vehicle(folder);
  const auto teeth = refine ? AngleAgain::Teeth::kAgain : AngleAgain::Teeth::kAsLive;
  if (vehicle) angles.emplace(*vehicle, AngleAgain::WithoutMark::kNoAngle, teeth);
  if (angles && angles->wanted())
    read_recording(
        folder, [](const VehicleConfig&) {}, [&](const SealedBlock& block) { angles->learn(block); });
  return read_recording(
      folder, reader.begin,
      [&](const SealedBlock& block) {
        if (clocks && block.kind == BlockKind::kScan)
          if (const auto fit = clocks->next(block.header)) reader.consume_fit(*fit);
        reader.consume(angles ? angles->again(block) : block);
      },
      [&](const ClockFit& fit) {
        if (!clocks || !clocks->knows(fit.node, fit.epoch)) reader.consume_fit(fit);
      });
}

}  // namespace roadbalance
