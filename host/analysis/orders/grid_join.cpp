#include "host/analysis/orders/grid_join.hpp"

#include <utility>

namespace roadbalance {

GridJoin::GridJoin(const std::vector<const NodeConfig*>& nodes, Emit emit, double longest_wait_s)
    : rows_(longest_wait_s), sample_(nodes.size()), emit_(std::move(emit)) {
  for (const NodeConfig* const node : nodes) rows_.add(*node, nodes.size() == 1);
}

void GridJoin::consume(const SealedBlock& block) {
  if (rows_.take(block)) emit();
}

void GridJoin::consume(const ScanBlock& block) {
  if (rows_.take(block)) emit();
}

void GridJoin::consume(const ClockFit& fit) {
  if (rows_.take(fit)) emit();
}

void GridJoin::emit() {
  while (const auto run = rows_.next()) {
    emit_rows(*run);
    rows_.use(*run);
  }
  rows_.drop_what_nobody_meets();
}

void GridJoin::emit_rows(const CommonRows::Run& run) {
  const auto& streams = rows_.streams();
  for (std::int64_t row = 0; row < run.rows; ++row) {
    for (std::size_t n = 0; n < streams.size(); ++n) {
      const GridRows& front = streams[n].rows.front();
      sample_[n] = {&front.counts[static_cast<std::size_t>(streams[n].row + row)], front.overload,
                    front.quality};
    }
    emit_({.restart = run.restart && row == 0, .sample = sample_});
  }
}

}  // namespace roadbalance
