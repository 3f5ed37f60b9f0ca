#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "common/clock/refine.hpp"
#include "common/link/block.hpp"

namespace roadbalance {

/// The clocks of a finished recording's nodes, computed again from its exchanges with what came before and
/// after each instant; see refine().
class RefinedClocks {
 public:
  /// @throws std::system_error if the folder cannot be read
  explicit RefinedClocks(const std::filesystem::path& folder);

  /// True if this epoch has exchanges enough.
  bool knows(std::int32_t node, std::int64_t epoch) const { return clocks_.contains({node, epoch}); }

  /// The fit to use from this block on, if it is another than before.  Blocks of an epoch in sequence.
  std::optional<ClockFit> next(const BlockHeader& block);

 private:
  struct Clock {
    RefinedFits fits;
    const ClockFit* used = nullptr;
  };
  std::map<std::pair<std::int32_t, std::int64_t>, Clock> clocks_;
};

}  // namespace roadbalance
