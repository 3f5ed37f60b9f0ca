#include "host/analyser/read_recording.hpp"

#include <memory>

#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/record/record.hpp"
#include "host/analyser/in_sequence.hpp"
#include "host/analyser/recorded_vehicle.hpp"

namespace roadbalance {

void read_recording(const std::filesystem::path& folder,
                    const std::function<void(const VehicleConfig&)>& begin,
                    const std::function<void(const SealedBlock&)>& consume) {
  RecordReader reader(folder);
  const auto vehicle = recorded_vehicle(folder);
  if (!vehicle) throw ConfigError(folder.string() + ": holds no complete vehicle.toml");
  begin(*vehicle);
  InSequence in_sequence;
  const auto block = std::make_unique<SealedBlock>();
  while (const auto event = reader.next())
    if (accept(event->data, *block) == Refusal::kNone) in_sequence.add(*block, consume);
}

}  // namespace roadbalance
