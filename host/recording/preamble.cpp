#include "host/recording/preamble.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/types.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/record_state.hpp"

namespace roadbalance {
namespace {

std::string description() {
  nlohmann::json types = nlohmann::json::array();
  for (const auto& type : recorded_types()) {
    char fingerprint[24];
    std::snprintf(fingerprint, sizeof fingerprint, "%016llx",
                  static_cast<unsigned long long>(type.fingerprint));
    types.push_back(
        {{"name", type.name}, {"fingerprint", fingerprint}, {"bytes", type.bytes}, {"lcm", type.text}});
  }
  const nlohmann::json text = {{"format", kRecordFormat},
                               {"format_version", kRecordFormatVersion},
                               {"program", "roadbalance " RB_VERSION},
                               {"events", "LCM event log; each message ends with its CRC-32C"},
                               {"types", types}};
  return text.dump();
}

void add(const MetaBlock& meta, RecordEvents& events) {
  SealedBlock sealed;
  seal(meta, sealed);
  events.emplace_back(block_channel(meta.header.node, BlockKind::kMeta),
                      std::vector<std::uint8_t>(sealed.bytes().begin(), sealed.bytes().end()));
}

// Made once: it is the same for every segment.
RecordEvents describe() {
  RecordEvents events;
  for (const MetaBlock& part : split_text(MetaKind::kRecordJson, description())) add(part, events);
  return events;
}

std::optional<RecordDescription> parse_description(const std::string& text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object() || json.value("format", "") != kRecordFormat) return std::nullopt;
  RecordDescription described{
      .program = json.value("program", ""), .format_version = json.value("format_version", 0), .types = {}};
  for (const auto& type : json.value("types", nlohmann::json::array()))
    described.types.push_back(type.value("name", ""));
  return described;
}

}  // namespace

RecordEvents make_preamble(const RecordState& holds) {
  return make_preamble(going_on(holds));
}

RecordEvents make_preamble(const RecordState::Descriptions& vehicle) {
  static const RecordEvents described = describe();
  RecordEvents events = described;
  for (const auto& [node_epoch, blocks] : vehicle)
    for (const auto& block : blocks) {
      MetaBlock meta = decode_meta(block);
      meta.header.sequence = 0;
      add(meta, events);
    }
  return events;
}

std::optional<RecordDescription> read_description(const std::filesystem::path& folder) {
  RecordReader reader(folder);
  SealedBlock block;
  std::string text;
  int next_part = 0;
  for (const int segment = reader.segment(); const auto event = reader.next();) {
    if (reader.segment() != segment) break;
    if (accept(*event, block) != Refusal::kNone || block.kind != BlockKind::kMeta) continue;
    const MetaBlock meta = decode_meta(block);
    if (meta.kind != MetaKind::kRecordJson || meta.part != next_part) continue;
    text += meta.text;
    if (++next_part == meta.parts) break;
  }
  try {
    return parse_description(text);
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace roadbalance
