#include "tools/import/imported_record.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "host/recording/manifest.hpp"
#include "host/recording/preamble.hpp"

namespace roadbalance {

ImportedRecord::ImportedRecord(const std::filesystem::path& folder, std::vector<std::string> origin,
                               std::int64_t begin_us, std::vector<ImportedMark> marks)
    : folder_(folder),
      origin_(std::move(origin)),
      record_({.folder = folder}),
      marks_(std::move(marks)),
      begin_us_(begin_us),
      written_us_(begin_us) {}

void ImportedRecord::add(std::size_t node, const SealedBlock& block) {
  if (latest_us_.size() <= node) latest_us_.resize(node + 1, begin_us_);
  latest_us_[node] = std::max(latest_us_[node], block.header.time_ns / 1000);
  // The description has no instant: the node's clock had not begun.
  const std::int64_t time_us = block.kind == BlockKind::kMeta ? begin_us_ : latest_us_[node];
  waiting_.emplace(std::pair(time_us, node), block);
}

void ImportedRecord::begin() {
  begun_ = true;
  RecordState::Descriptions metas;
  for (const auto& [place, block] : waiting_)
    if (block.kind == BlockKind::kMeta) metas[{block.header.node, block.header.epoch}].push_back(block);
  record_.set_preamble([events = make_preamble(metas)](const RecordState&) { return events; });
  for (const std::string& text : origin_) put({.kind = NoteKind::kImported, .text = text}, begin_us_);
}

void ImportedRecord::append(std::string_view channel, std::span<const std::uint8_t> bytes,
                            std::int64_t time_us) {
  written_us_ = std::max(written_us_, time_us);
  record_.append(channel, bytes, written_us_);
}

void ImportedRecord::put(const Note& note, std::int64_t time_us) {
  append(kNoteChannel, encode(note), time_us);
}

void ImportedRecord::put_marks_before(std::int64_t time_us) {
  for (; next_mark_ < marks_.size(); ++next_mark_) {
    const ImportedMark& mark = marks_[next_mark_];
    const std::int64_t mark_us = std::llround(mark.time_s * 1e6);
    if (mark_us >= time_us) return;
    put({.host_ns = std::llround(mark.time_s * 1e9),
         .kind = NoteKind::kMark,
         .a = mark.number,
         .text = mark.text},
        mark_us);
  }
}

void ImportedRecord::write_before(std::int64_t time_us) {
  if (!begun_) begin();
  auto next = waiting_.begin();
  for (; next != waiting_.end() && next->first.first < time_us; ++next) {
    put_marks_before(next->first.first);
    const SealedBlock& block = next->second;
    append(block_channel(block.header.node, block.kind), block.bytes(), next->first.first);
  }
  waiting_.erase(waiting_.begin(), next);
}

void ImportedRecord::finish() {
  constexpr std::int64_t kEver_us = std::numeric_limits<std::int64_t>::max();
  write_before(kEver_us);
  put_marks_before(kEver_us);
  record_.sync();
  record_.close();
  write_manifest(folder_);
}

}  // namespace roadbalance
