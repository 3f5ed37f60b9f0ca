#include "host/analysis/angle/read_with_angles.hpp"

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "common/bus/clock_messages.hpp"
#include "common/clock/refine.hpp"
#include "common/record/record_reader.hpp"
#include "host/recording/recorded_vehicle.hpp"

namespace roadbalance {
namespace {

/// The clocks of a finished recording's nodes, computed again from its exchanges with what came before and
/// after each instant; see refine().
class RefinedClocks {
 public:
  /// @throws std::system_error if the folder cannot be read
  explicit RefinedClocks(const std::filesystem::path& folder);

  /// True if this epoch has exchanges enough.
  bool knows(std::int32_t node, std::int64_t epoch) const { return clocks_.contains({node, epoch}); }

  /// The fit to use from this block on, if it is another than before.  Blocks of an epoch in sequence.
  std::optional<ClockFit> next(const BlockHeader& block);

 private:
  struct Clock {
    RefinedFits fits;
    const ClockFit* used = nullptr;
  };
  std::map<std::pair<std::int32_t, std::int64_t>, Clock> clocks_;
};

RefinedClocks::RefinedClocks(const std::filesystem::path& folder) {
  std::map<std::pair<std::int32_t, std::int64_t>, std::vector<ClockExchange>> exchanges;
  RecordReader reader(folder);
  reader.finish();
  while (const auto event = reader.next())
    if (const auto exchange = decode_clock_exchange(event->data))
      exchanges[{exchange->node, exchange->epoch}].push_back(*exchange);
  for (const auto& [key, of_epoch] : exchanges)
    if (auto fits = refine(of_epoch); !fits.empty())
      clocks_.emplace(key, Clock{RefinedFits(std::move(fits))});
}

std::optional<ClockFit> RefinedClocks::next(const BlockHeader& block) {
  const auto found = clocks_.find({block.node, block.epoch});
  if (found == clocks_.end()) return std::nullopt;
  Clock& clock = found->second;
  const ClockFit* const fit = clock.fits.at(block.time_ns);
  if (std::exchange(clock.used, fit) == fit) return std::nullopt;
  return *fit;
}

}  // namespace

RecordingDefects read_with_angles(const std::filesystem::path& folder, bool refine,
                                  std::optional<AngleReprocessor>& angles, const BlockReader& reader) {
  std::optional<RefinedClocks> clocks;
  if (refine) clocks.emplace(folder);
  const auto vehicle = recorded_vehicle(folder);
  const auto teeth = refine ? AngleReprocessor::Teeth::kAgain : AngleReprocessor::Teeth::kAsLive;
  if (vehicle) angles.emplace(*vehicle, AngleReprocessor::WithoutMark::kNoAngle, teeth);
  if (angles && angles->wanted())
    read_recording(
        folder, [](const VehicleConfig&) {}, [&](const SealedBlock& block) { angles->learn(block); });
  return read_recording(
      folder, reader.begin,
      [&](const SealedBlock& block) {
        if (clocks && block.kind == BlockKind::kScan)
          if (const auto fit = clocks->next(block.header)) reader.consume_fit(*fit);
        reader.consume(angles ? angles->reprocess(block) : block);
      },
      [&](const ClockFit& fit) {
        if (!clocks || !clocks->knows(fit.node, fit.epoch)) reader.consume_fit(fit);
      },
      reader.consume_other);
}

}  // namespace roadbalance
