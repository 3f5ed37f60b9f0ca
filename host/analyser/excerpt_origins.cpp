#include "host/analyser/excerpt_origins.hpp"

#include "common/bus/codec.hpp"
#include "common/bus/notes.hpp"
#include "common/record/record.hpp"

namespace roadbalance {

std::map<std::int64_t, std::int64_t> excerpt_origins(const std::filesystem::path& folder) {
  RecordReader reader(folder);
  reader.finish();
  bool is_excerpt = false;  // which is said before its first scan
  std::map<std::int64_t, std::int64_t> made_of;
  while (const auto event = reader.next()) {
    if (!is_excerpt && event->channel.ends_with("_SCAN")) return {};
    const auto note = event->channel == kNoteChannel ? decode_note(event->data) : std::nullopt;
    if (!note) continue;
    is_excerpt = is_excerpt || note->kind == NoteKind::kExcerpt;
    if (note->kind == NoteKind::kExcerptEpoch) made_of.emplace(note->a, note->b);
  }
  std::map<std::int64_t, std::int64_t> origins;
  for (const auto& [epoch, before] : made_of) {
    std::int64_t origin = before;
    // No more steps than there are notes: hostile ones may form a ring.
    for (std::size_t step = 0; step < made_of.size() && made_of.contains(origin); ++step)
      origin = made_of.at(origin);
    origins[epoch] = origin;
  }
  return origins;
}

}  // namespace roadbalance
