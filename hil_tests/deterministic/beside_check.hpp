#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "common/types/block.hpp"
#include "common/types/scan.hpp"
#include "hil_tests/deterministic/truth.hpp"

namespace roadbalance::test {

/// Edges and signals of one epoch, as its device gave them and as its node seals them: each edge and
/// each sample once, in order, or inside a gap; the first edge of a line behind lost ones is marked, and no
/// other.
class BesideCheck {
 public:
  BesideCheck(Truth& truth, std::int32_t node, std::int64_t period_ns)
      : truth_(truth), node_(node), period_ns_(period_ns) {}

  /// Between start and stop; in order of time, no later than the next scan.
  void given(const Edge& edge) { edges_.push_back(edge); }
  void given(const SignalSample& sample) { samples_.push_back(sample); }
  /// Each block of the epoch, in sequence.
  void sealed(const SealedBlock& block);

 private:
  struct Gap {
    std::int64_t begin_ns, end_ns;
  };
  bool is_in_a_gap(NodeTime time) const;
  void take(const Edge& edge);
  void take(const SignalSample& sample);
  void check_lost();
  void fault(const std::string& what);

  Truth& truth_;
  const std::int32_t node_;
  const std::int64_t period_ns_;
  std::deque<Edge> edges_;            // given, not yet seen
  std::deque<SignalSample> samples_;  // the same
  std::array<bool, kEncoderLines> hole_{}, marked_{};
  std::vector<Edge> lost_edges_;            // not yet found in a gap
  std::vector<SignalSample> lost_samples_;  // the same
  std::vector<Gap> gaps_;
};

}  // namespace roadbalance::test
