#include "firmware/backends/replay/recorded_drive.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/config/section.hpp"

namespace roadbalance {
namespace {

// Few edges wait a second for others, then for the end of a block of scans; these may wait 100 ms for a
// reference.
constexpr auto kLookAhead = std::chrono::milliseconds(1500);
constexpr auto kPiece = std::chrono::milliseconds(50);  // small enough for a near cache, at 10 kHz too

/// Runs of the node that the record holds scans of.
std::set<std::int64_t> runs_of(const std::filesystem::path& folder, std::int32_t node) {
  std::set<std::int64_t> runs;
  RecordReader reader(folder);
  reader.finish();
  SealedBlock block;
  while (const auto event = reader.next())
    if (accept(*event, block) == Refusal::kNone && block.kind == BlockKind::kScan &&
        block.header.node == node)
      runs.insert(block.header.epoch);
  return runs;
}

std::int64_t choose_run(const std::filesystem::path& folder, std::int32_t node,
                        std::optional<std::int64_t> epoch) {
  const std::set<std::int64_t> runs = runs_of(folder, node);
  std::string known;
  for (const std::int64_t run : runs) known += (known.empty() ? "" : ", ") + std::to_string(run);
  if (runs.empty())
    throw ConfigError("recording " + folder.string() + ": holds no scan of node " + std::to_string(node));
  if (epoch ? !runs.contains(*epoch) : runs.size() > 1)
    throw ConfigError("recording " + folder.string() + ": which run of node " + std::to_string(node) +
                      " to replay; allowed: epoch=N, N one of " + known);
  return epoch.value_or(*runs.begin());
}

/// Moves what is not younger than `until` from one end of `from` to `to`.
template <typename Item>
void move_until(NodeTime until, std::deque<Item>& from, std::vector<Item>& to) {
  const auto end =
      std::find_if(from.begin(), from.end(), [&](const Item& item) { return item.time > until; });
  to.insert(to.end(), from.begin(), end);
  from.erase(from.begin(), end);
}

}  // namespace

RecordedDrive::RecordedDrive(const std::filesystem::path& folder, std::int32_t node,
                             std::optional<std::int64_t> epoch)
    : reader_(folder), node_(node), epoch_(choose_run(folder, node, epoch)) {
  reader_.finish();
  fill();
  if (scans_.empty()) throw ConfigError("recording " + folder.string() + ": its scans are damaged");
  first_scan_ = scans_.front().time;
}

std::optional<RecordedPiece> RecordedDrive::next() {
  fill();
  if (scans_.empty() && edges_.empty() && signals_.empty()) return std::nullopt;
  const bool last = over_ && (scans_.empty() || scans_.back().time - scans_.front().time <= kPiece);
  const NodeTime until = last ? NodeTime::max() : scans_.front().time + kPiece;
  RecordedPiece piece;
  move_until(until, scans_, piece.scans);
  move_until(until, edges_, piece.edges);
  move_until(until, signals_, piece.signals);
  return piece;
}

void RecordedDrive::fill() {
  while (!over_ && (scans_.empty() || scans_.back().time - scans_.front().time < kPiece + kLookAhead)) {
    const auto event = reader_.next();
    if (!event) {
      over_ = true;
      return;
    }
    if (accept(*event, *block_) != Refusal::kNone || block_->header.node != node_ ||
        block_->header.epoch != epoch_ || block_->header.sequence <= last_sequence_)
      continue;
    last_sequence_ = block_->header.sequence;
    over_ = take(*block_);
  }
}

/// True at the end.
bool RecordedDrive::take(const SealedBlock& block) {
  if (block.kind == BlockKind::kScan) {
    const ScanBlock read = decode_scan(block);
    for (std::int64_t row = 0; row < read.header.scans; ++row) {
      const auto& counts = read.counts[static_cast<std::size_t>(row)];
      Scan& scan = scans_.emplace_back();
      scan.index = read.header.first_scan + row;
      scan.time = node_time_from_ns(read.row_time_ns(row));
      std::copy_n(counts.begin(), kAccelerations, scan.counts.begin());
      std::copy_n(counts.begin() + kAccelerations, kReferences, scan.references.begin());
      scan.overload = static_cast<std::uint32_t>(read.overload);
      scan.after_absence = std::exchange(absent_, false);
      scan.after_sleep = std::exchange(slept_, false);
    }
  } else if (block.kind == BlockKind::kEdge) {
    const std::vector<Edge> edges = decode_edge(block).unpack();
    edges_.insert(edges_.end(), edges.begin(), edges.end());
  } else if (block.kind == BlockKind::kSignal) {
    const std::vector<SignalSample> samples = decode_signal(block).unpack();
    signals_.insert(signals_.end(), samples.begin(), samples.end());
  } else if (block.kind == BlockKind::kGap) {
    const GapCause cause = decode_gap(block).cause;
    absent_ = absent_ || cause == GapCause::kDeviceGone;
    slept_ = slept_ || cause == GapCause::kSlept;
  }
  return block.kind == BlockKind::kEnd;
}

}  // namespace roadbalance
