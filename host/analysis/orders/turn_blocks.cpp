#include "host/analysis/orders/turn_blocks.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace roadbalance {

TurnBlocks::TurnBlocks(const Settings& settings, Emit emit) : settings_(settings), emit_(std::move(emit)) {
  if (settings.channels < 1 || settings.rows_per_turn < 2 || settings.turns < 1)
    throw std::invalid_argument("order analysis: a block needs channels, rows and turns");
  if (settings.hop < 1 || settings.hop > settings.turns)
    throw std::invalid_argument("order analysis: the next block begins 1 turn .. a block later");
  block_.values.resize(settings.turns * settings.rows_per_turn, settings.channels);
  time_s_.resize(block_.values.rows());
  turn_overload_.resize(static_cast<std::size_t>(settings.turns));
}

void TurnBlocks::add(const AngleRow& row) {
  if (row.restart) {
    filled_ = 0;
    ++block_.run;
  }
  const std::int64_t in_turn = row.index % settings_.rows_per_turn;
  if (filled_ == 0) {
    if (in_turn != 0) return;
    block_.first_turn = row.index / settings_.rows_per_turn;
  }
  block_.values.row(filled_) = row.values.transpose();
  time_s_(filled_) = row.time_s;
  std::uint32_t& overload = turn_overload_[static_cast<std::size_t>(filled_ / settings_.rows_per_turn)];
  overload = (in_turn == 0 ? 0 : overload) | row.overload;
  if (++filled_ == block_.values.rows()) emit_block();
}

void TurnBlocks::emit_block() {
  const Eigen::Index rows = block_.values.rows();
  block_.rotation_hz =
      static_cast<double>(rows - 1) / settings_.rows_per_turn / (time_s_(rows - 1) - time_s_(0));
  block_.from_s = time_s_(0);
  block_.to_s = time_s_(rows - 1) + 1.0 / (block_.rotation_hz * settings_.rows_per_turn);
  block_.overload = 0;
  for (const std::uint32_t overload : turn_overload_) block_.overload |= overload;
  emit_(block_);
  const Eigen::Index hop = settings_.hop * settings_.rows_per_turn;
  filled_ = rows - hop;
  block_.values.topRows(filled_) = block_.values.bottomRows(filled_).eval();
  time_s_.head(filled_) = time_s_.tail(filled_).eval();
  std::copy(turn_overload_.begin() + settings_.hop, turn_overload_.end(), turn_overload_.begin());
  block_.first_turn += settings_.hop;
}

}  // namespace roadbalance
