#include "hil_tests/deterministic/beside_check.hpp"

#include <algorithm>
#include <limits>

#include "common/bus/codec.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kOpen = std::numeric_limits<std::int64_t>::max();

}  // namespace

void BesideCheck::fault(const std::string& what) {
  truth_.fault("node " + std::to_string(node_) + ": " + what);
}

void BesideCheck::sealed(const SealedBlock& block) {
  switch (block.kind) {
    case BlockKind::kEdge:
      for (const Edge& edge : decode_edge(block).unpack()) take(edge);
      return;
    case BlockKind::kSignal:
      for (const SignalSample& sample : decode_signal(block).unpack()) take(sample);
      return;
    case BlockKind::kGap:
      // Between the scan before it and the one behind it.
      gaps_.push_back({.begin_ns = block.header.time_ns - period_ns_, .end_ns = kOpen});
      return;
    case BlockKind::kScan:
      if (!gaps_.empty() && gaps_.back().end_ns == kOpen) gaps_.back().end_ns = block.header.time_ns;
      return check_lost();
    case BlockKind::kEnd:
      lost_edges_.insert(lost_edges_.end(), edges_.begin(), edges_.end());
      lost_samples_.insert(lost_samples_.end(), samples_.begin(), samples_.end());
      return check_lost();
    default:
      return;
  }
}

void BesideCheck::take(const Edge& edge) {
  if (edge.kind == EdgeKind::kLost) {
    marked_[edge.line] = true;
    return;
  }
  const auto is_it = [&](const Edge& e) {
    return e.time == edge.time && e.line == edge.line && e.kind == edge.kind;
  };
  for (; !edges_.empty() && !is_it(edges_.front()); edges_.pop_front()) {
    hole_[edges_.front().line] = true;
    lost_edges_.push_back(edges_.front());
  }
  if (edges_.empty()) return fault("sealed an edge that no device gave");
  edges_.pop_front();
  if (marked_[edge.line] != hole_[edge.line])
    fault(hole_[edge.line] ? "no mark stands behind lost edges" : "a mark says that edges are lost; none is");
  marked_[edge.line] = hole_[edge.line] = false;
}

void BesideCheck::take(const SignalSample& sample) {
  const auto is_it = [&](const SignalSample& s) {
    return s.time == sample.time && s.signal == sample.signal && s.value == sample.value;
  };
  for (; !samples_.empty() && !is_it(samples_.front()); samples_.pop_front())
    lost_samples_.push_back(samples_.front());
  if (samples_.empty()) return fault("sealed a signal that no device gave");
  samples_.pop_front();
}

bool BesideCheck::is_in_a_gap(NodeTime time) const {
  return std::ranges::any_of(
      gaps_, [&](const Gap& gap) { return gap.begin_ns <= to_ns(time) && to_ns(time) < gap.end_ns; });
}

void BesideCheck::check_lost() {
  for (const Edge& edge : lost_edges_)
    is_in_a_gap(edge.time) ? truth_.lost_edge() : fault("lost an edge outside of any gap");
  for (const SignalSample& sample : lost_samples_)
    is_in_a_gap(sample.time) ? truth_.lost_signal() : fault("lost a signal outside of any gap");
  lost_edges_.clear();
  lost_samples_.clear();
}

}  // namespace roadbalance::test
