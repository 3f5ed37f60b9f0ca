#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "common/link/planted.hpp"

namespace roadbalance::test {

/// Names of the planted faults for the command line, in the order of PlantedFault behind kNone.
inline constexpr std::array<std::string_view, 17> kPlantedNames{
    "free_on_receive", "epoch_reused",     "no_heartbeat",      "no_deduplication",   "overwrite_oldest",
    "ack_before_sync", "silent_ring_full", "gap_off_by_one",    "no_crash_gap",       "stale_recorder",
    "no_folder_sync",  "torn_tail_kept",   "retry_failed_sync", "lost_declared_late", "blocks_swapped",
    "block_altered",   "one_too_many_lost"};
static_assert(kPlantedNames.size() == static_cast<std::size_t>(PlantedFault::kOneTooManyLost));

constexpr std::optional<PlantedFault> planted_named(std::string_view name) {
  for (std::size_t k = 0; k < kPlantedNames.size(); ++k)
    if (kPlantedNames[k] == name) return static_cast<PlantedFault>(k + 1);
  return std::nullopt;
}

/// "free_on_receive epoch_reused ...".
inline std::string all_planted_names() {
  std::string all;
  for (const std::string_view name : kPlantedNames) (all += all.empty() ? "" : " ") += name;
  return all;
}

/// Option that plants the fault in a command line, too: nothing, or " --plant NAME".
inline std::string plant_option(PlantedFault fault) {
  if (fault == PlantedFault::kNone) return {};
  return " --plant " + std::string(kPlantedNames[static_cast<std::size_t>(fault) - 1]);
}

}  // namespace roadbalance::test
