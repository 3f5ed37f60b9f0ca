#pragma once

#include <cstdint>
#include <string>

#include "common/types/block.hpp"

namespace roadbalance {

/// A stretch of a recording in which a node did not measure.
struct Absence {
  std::int32_t node = 0;
  AbsenceCause cause = AbsenceCause::kNone;
  std::int64_t since_us = 0;  ///< UTC
  double seconds = 0.0;
  bool from_begin = false;  ///< of the recording
  bool to_end = false;      ///< of the recording, or so far

  bool operator==(const Absence&) const = default;
};

/// "its program was ended: by its service, a person or a closed terminal"
const char* words(AbsenceCause cause);

/// "ended 38 s before the recording: its program was ended ...", "came 20 s late", "was away for 5.2 s: ...".
std::string words(const Absence& absence);

/// "node 2 (rear)"; without a name "node 2".
std::string node_words(std::int32_t node, const std::string& name);

}  // namespace roadbalance
