#include "host/recording/read_recording.hpp"

#include <memory>

#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record_reader.hpp"
#include "host/recording/in_sequence.hpp"
#include "host/recording/manifest.hpp"
#include "host/recording/recorded_vehicle.hpp"

namespace roadbalance {

RecordingDefects read_recording(const std::filesystem::path& folder,
                                const std::function<void(const VehicleConfig&)>& begin,
                                const std::function<void(const SealedBlock&)>& consume,
                                const std::function<void(const ClockFit&)>& consume_fit,
                                const std::function<void(const LogEvent&)>& consume_other) {
  RecordReader reader(folder);
  begin(vehicle_of_recording(folder));
  reader.finish();
  InSequence in_sequence = InSequence::of_record(folder);
  RecordingDefects defects;
  const auto block = std::make_unique<SealedBlock>();
  while (const auto event = reader.next()) switch (accept(*event, *block)) {
      case Refusal::kNone:
        in_sequence.add(*block, consume);
        break;
      case Refusal::kUnknownType:  // the record holds more than blocks
        if (consume_other) consume_other(*event);
        if (const auto fit = consume_fit ? decode_clock_fit(event->data) : std::nullopt) consume_fit(*fit);
        break;
      default:
        ++defects.refused_blocks;
    }
  defects.damaged_bytes = damaged_bytes(folder, reader);
  defects.missing_blocks = in_sequence.missing();
  return defects;
}

}  // namespace roadbalance
