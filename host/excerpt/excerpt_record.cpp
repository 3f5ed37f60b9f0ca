#include "host/excerpt/excerpt_record.hpp"

#include "common/bus/codec.hpp"
#include "host/recorder/manifest.hpp"
#include "host/recorder/preamble.hpp"

namespace roadbalance {
namespace {

/// Of one epoch in an entry of the journal: about a second of one.
constexpr std::int64_t kBlocksPerEntry = 128;

}  // namespace

ExcerptRecord::ExcerptRecord(const std::filesystem::path& folder)
    : folder_(folder), writer_({.folder = folder}) {
  writer_.set_preamble([](const RecordState& holds) { return make_preamble(holds); });
}

void ExcerptRecord::put(std::string_view channel, std::span<const std::uint8_t> data) {
  writer_.append(channel, data, timestamp_us_);
}

void ExcerptRecord::put(const SealedBlock& block, const NodeLosses& losses) {
  writer_.append(block, timestamp_us_);
  journal_.add(block);
  const NodeEpoch key{block.header.node, block.header.epoch};
  Open& open = open_[key];
  open.losses = losses;
  ++open.blocks;
  const bool ends = block.kind == BlockKind::kEnd;
  if (open.blocks >= kBlocksPerEntry || ends) write_entry(key, open);
  if (ends) open_.erase(key);
}

void ExcerptRecord::write_entry(const NodeEpoch& key, Open& open) {
  open.blocks = 0;
  Journal entry = journal_.take(key.first, key.second);
  entry.time_us = timestamp_us_;
  entry.node_losses = open.losses;
  put(kJournalChannel, encode(entry));
}

void ExcerptRecord::close() {
  for (auto& [key, open] : open_)
    if (open.blocks > 0) write_entry(key, open);
  writer_.close();
  write_manifest(folder_);
}

}  // namespace roadbalance
