#include "common/bus/types.hpp"

#include <algorithm>
#include <utility>
#include <wire/clock_exchange_t.hpp>
#include <wire/clock_fit_t.hpp>
#include <wire/commit_t.hpp>
#include <wire/edge_block_t.hpp>
#include <wire/end_t.hpp>
#include <wire/gap_t.hpp>
#include <wire/journal_t.hpp>
#include <wire/meta_t.hpp>
#include <wire/note_t.hpp>
#include <wire/scan_block_t.hpp>
#include <wire/signal_block_t.hpp>

#include "common/bus/notes.hpp"
#include "common/bus/wire_format.hpp"
#include "embedded/clock_exchange_t.hpp"
#include "embedded/clock_fit_t.hpp"
#include "embedded/commit_t.hpp"
#include "embedded/edge_block_t.hpp"
#include "embedded/end_t.hpp"
#include "embedded/gap_t.hpp"
#include "embedded/journal_t.hpp"
#include "embedded/meta_t.hpp"
#include "embedded/note_t.hpp"
#include "embedded/scan_block_t.hpp"
#include "embedded/signal_block_t.hpp"

namespace roadbalance {
namespace {

template <typename Message>
RecordedType type_of(std::string_view text) {
  std::string name = "wire.";
  name += Message::getTypeName();
  return {.name = std::move(name),
          .fingerprint = Message::getHash(),
          .bytes = wire_format::size_of<Message>(),
          .text = text};
}

}  // namespace

std::vector<RecordedType> block_types() {
  return {type_of<wire::scan_block_t>(embedded::kScanBlockT),
          type_of<wire::edge_block_t>(embedded::kEdgeBlockT),
          type_of<wire::gap_t>(embedded::kGapT),
          type_of<wire::meta_t>(embedded::kMetaT),
          type_of<wire::end_t>(embedded::kEndT),
          type_of<wire::signal_block_t>(embedded::kSignalBlockT)};
}

std::vector<RecordedType> recorded_types() {
  auto types = block_types();
  types.insert(types.end(),
               {type_of<wire::journal_t>(embedded::kJournalT), type_of<wire::note_t>(embedded::kNoteT),
                type_of<wire::commit_t>(embedded::kCommitT),
                type_of<wire::clock_exchange_t>(embedded::kClockExchangeT),
                type_of<wire::clock_fit_t>(embedded::kClockFitT)});
  return types;
}

bool is_of_newer_release(std::span<const std::uint8_t> bytes) {
  static const auto known = recorded_types();
  if (bytes.size() < sizeof(RecordedType::fingerprint) + wire_format::kCrcBytes || !ends_with_its_crc(bytes))
    return false;
  if (const auto note = wire_format::decode<wire::note_t>(bytes))
    return note->kind > static_cast<std::int32_t>(NoteKind::kLast);
  return std::ranges::find(known, wire_format::load_i64(bytes.data()), &RecordedType::fingerprint) ==
         known.end();
}

}  // namespace roadbalance
