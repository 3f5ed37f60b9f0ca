#include "host/analyser/recorded_vehicle.hpp"

#include <map>
#include <memory>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/record/record.hpp"

namespace roadbalance {
namespace {

bool holds_a_segment(const std::filesystem::path& folder) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (entry.path().extension() == ".lcm") return true;
  return false;
}

}  // namespace

std::optional<VehicleConfig> recorded_vehicle(const std::filesystem::path& folder) {
  if (!holds_a_segment(folder)) return std::nullopt;
  RecordReader reader(folder);
  std::map<std::pair<int, std::int64_t>, std::map<int, std::string>> parts;  // of a node's epoch
  const auto block = std::make_unique<SealedBlock>();
  while (const auto event = reader.next()) {
    if (accept(event->data, *block) != Refusal::kNone || block->kind != BlockKind::kMeta) continue;
    const MetaBlock meta = decode_meta(*block);
    if (meta.kind != MetaKind::kVehicleToml) continue;
    auto& text = parts[{meta.header.node, meta.header.epoch}];
    text[meta.part] = meta.text;
    if (std::ssize(text) < meta.parts) continue;
    std::string whole;
    for (const auto& [number, part] : text) whole += part;
    return VehicleConfig::parse(whole, folder.string() + ": vehicle.toml");
  }
  return std::nullopt;
}

}  // namespace roadbalance
