#include "hil_tests/deterministic/truth.hpp"

namespace roadbalance::test {
namespace {
constexpr std::size_t kFaultsKept = 20;
}  // namespace

std::uint32_t crc_of(const SealedBlock& block) {
  const auto bytes = block.bytes().last(4);
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 |
         bytes[3];
}

void EpochTruth::drop_through(std::int64_t sequence) {
  constexpr std::int64_t kWorthIt = 1 << 16;
  if (sequence - dropped < kWorthIt) return;
  blocks.erase(blocks.begin(), blocks.begin() + static_cast<std::ptrdiff_t>(sequence - dropped));
  dropped = sequence;
}

EpochTruth& Truth::open(std::int32_t node, std::int64_t epoch) {
  const auto [at, is_new] = epochs_.try_emplace({node, epoch});
  if (!is_new) fault("node " + std::to_string(node) + " began an epoch it had before");
  at->second.node = node;
  at->second.epoch = epoch;
  ++at->second.openings;
  return at->second;
}

EpochTruth* Truth::find(std::int32_t node, std::int64_t epoch) {
  const auto found = epochs_.find({node, epoch});
  return found == epochs_.end() ? nullptr : &found->second;
}

bool Truth::may_be_in(const EpochTruth& epoch, const std::string& recording) const {
  const auto found = leads_.find(epoch.started_by);
  return found == leads_.end() || found->second.contains(recording);
}

void Truth::sealed(EpochTruth& epoch, const SealedBlock& block, std::int64_t now_ns) {
  if (block.header.sequence != epoch.next())
    fault("node " + std::to_string(epoch.node) + " sealed block " + std::to_string(block.header.sequence) +
          " after " + std::to_string(epoch.next() - 1));
  epoch.blocks.push_back({crc_of(block), now_ns});
  epoch.ended = epoch.ended || block.kind == BlockKind::kEnd;
  ++blocks_sealed_;
}

void Truth::ends(std::int32_t node, AbsenceCause cause) {
  for (Measured& one : measured_)
    if (one.node == node && one.to_ns == 0) {
      one.to_ns = now_ns_;
      one.end = cause;
    }
}

void Truth::fault(const std::string& what) {
  if (fault_count_++ >= static_cast<std::int64_t>(kFaultsKept)) return;
  faults_.push_back(std::to_string(static_cast<double>(now_ns_) * 1e-9) + " s: " + what);
}

}  // namespace roadbalance::test
