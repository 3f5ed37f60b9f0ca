#include "host/recording/recorded_vehicle.hpp"

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/bus/other_wire.hpp"
#include "common/record/record_reader.hpp"
#include "host/recording/foreign_log.hpp"

namespace roadbalance {
namespace {

bool holds_a_segment(const std::filesystem::path& folder) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (entry.path().extension() == ".lcm") return true;
  return false;
}

/// An imported recording keeps the rate that was fitted to its stamps.
void set_rate(VehicleConfig& vehicle, std::int64_t period_ps) {
  const double rate_hz = 1e12 / static_cast<double>(period_ps);
  vehicle.drive.identification_rate_hz *= rate_hz / vehicle.node.front().rate_hz;
  for (auto& node : vehicle.node) node.rate_hz = rate_hz;
}

}  // namespace

std::optional<VehicleConfig> recorded_vehicle(const std::filesystem::path& folder) {
  if (!holds_a_segment(folder)) return std::nullopt;
  RecordReader reader(folder);
  std::map<std::pair<int, std::int64_t>, std::map<int, std::string>> parts;  // of a node's epoch
  std::optional<VehicleConfig> vehicle;
  const auto block = std::make_unique<SealedBlock>();
  OtherWire other_wire;
  while (const auto event = reader.next()) {
    other_wire.take(event->channel, event->data);
    if (accept(*event, *block) != Refusal::kNone) continue;
    if (vehicle && block->kind == BlockKind::kScan) {
      set_rate(*vehicle, decode_scan(*block).period_ps);
      return vehicle;
    }
    if (vehicle || block->kind != BlockKind::kMeta) continue;
    const MetaBlock meta = decode_meta(*block);
    if (meta.kind != MetaKind::kVehicleToml) continue;
    auto& text = parts[{meta.header.node, meta.header.epoch}];
    text[meta.part] = meta.text;
    if (std::ssize(text) < meta.parts) continue;
    std::string whole;
    for (const auto& [number, part] : text) whole += part;
    vehicle = VehicleConfig::parse(whole, folder.string() + ": vehicle.toml");
  }
  if (const auto other = other_wire.sentences(); !other.empty())
    throw std::runtime_error("recording " + folder.string() + ": " + other.front());
  return std::nullopt;
}

VehicleConfig vehicle_of_recording(const std::filesystem::path& folder) {
  if (auto vehicle = recorded_vehicle(folder)) return std::move(*vehicle);
  const std::string foreign = foreign_words(folder);
  throw std::runtime_error(folder.string() + ": " +
                           (foreign.empty() ? "holds no complete vehicle.toml, or no scan" : foreign));
}

}  // namespace roadbalance
