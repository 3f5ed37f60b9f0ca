#include "host/recorder/preamble.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/types.hpp"

namespace roadbalance {
namespace {

std::string description() {
  nlohmann::json types = nlohmann::json::array();
  for (const auto& type : block_types()) {
    char fingerprint[24];
    std::snprintf(fingerprint, sizeof fingerprint, "%016llx",
                  static_cast<unsigned long long>(type.fingerprint));
    types.push_back({{"name", type.name}, {"fingerprint", fingerprint}, {"bytes", type.bytes}});
  }
  const nlohmann::json text = {{"format", kRecordFormat},
                               {"format_version", kRecordFormatVersion},
                               {"events", "LCM event log; each block ends with its CRC-32C"},
                               {"block_types", types}};
  return text.dump();
}

void add(const MetaBlock& meta, RecordEvents& events) {
  SealedBlock sealed;
  seal(meta, sealed);
  events.emplace_back(block_channel(meta.header.node, BlockKind::kMeta),
                      std::vector<std::uint8_t>(sealed.bytes().begin(), sealed.bytes().end()));
}

}  // namespace

RecordEvents make_preamble(const RecordState& holds) {
  return make_preamble(going_on(holds));
}

RecordEvents make_preamble(const std::map<NodeEpoch, std::vector<SealedBlock>>& vehicle) {
  RecordEvents events;
  for (const MetaBlock& part : split_text(MetaKind::kRecordJson, description())) add(part, events);
  for (const auto& [node_epoch, blocks] : vehicle)
    for (const auto& block : blocks) {
      MetaBlock meta = decode_meta(block);
      meta.header.sequence = 0;
      add(meta, events);
    }
  return events;
}

}  // namespace roadbalance
