#pragma once

#include <string>

namespace roadbalance {

/// One thing that a measurement needs, in one sentence.
struct Finding {
  enum State { kWell, kNote, kIll };  ///< note: works, though not as well as it could
  std::string name;
  State state = kWell;
  std::string sentence;
  std::string remedy;  ///< the command that mends it; empty if well
};

}  // namespace roadbalance
