#include "host/analyser/identify_record.hpp"

#include <memory>

#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/record/record.hpp"
#include "host/analyser/in_sequence.hpp"
#include "host/analyser/recorded_vehicle.hpp"

namespace roadbalance {

DriveEstimate identify_record(const std::filesystem::path& folder) {
  RecordReader reader(folder);
  const auto vehicle = recorded_vehicle(folder);
  if (!vehicle) throw ConfigError(folder.string() + ": holds no complete vehicle.toml");
  DriveEstimator estimator(*vehicle);
  InSequence in_sequence;
  const auto block = std::make_unique<SealedBlock>();
  while (const auto event = reader.next())
    if (accept(event->data, *block) == Refusal::kNone)
      in_sequence.add(*block, [&](const SealedBlock& next) { estimator.consume(next); });
  return estimator.estimate();
}

}  // namespace roadbalance
