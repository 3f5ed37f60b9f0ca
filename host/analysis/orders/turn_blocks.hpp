#pragma once

#include <cstdint>
#include <functional>

#include "host/analysis/orders/angle_sampler.hpp"

namespace roadbalance {

/// Whole turns without an interruption, from one passage of angle 0 to another.
struct TurnBlock {
  std::int64_t first_turn = 0;      ///< counted since the angle became known
  std::int64_t run = 0;             ///< which uninterrupted stretch it is of
  double rotation_hz = 0.0;         ///< mean
  double from_s = 0.0, to_s = 0.0;  ///< AngleRow::time_s of its first row, and where the next one is due
  std::uint32_t overload = 0;       ///< bit k: channel k is not to be used
  Eigen::MatrixXd values;           ///< [row x channel]
};

/// Gathers rows into blocks.
class TurnBlocks {
 public:
  struct Settings {
    int channels;
    int rows_per_turn;
    int turns;  ///< of a block
    int hop;    ///< turns from one block to the next, 1 .. turns
  };
  using Emit = std::function<void(const TurnBlock&)>;

  /// @throws std::invalid_argument
  TurnBlocks(const Settings& settings, Emit emit);

  void add(const AngleRow& row);

 private:
  void emit_block();

  Settings settings_;
  TurnBlock block_;
  Eigen::VectorXd time_s_;                    ///< [row]
  std::vector<std::uint32_t> turn_overload_;  ///< [turn]
  Eigen::Index filled_ = 0;
  Emit emit_;
};

}  // namespace roadbalance
