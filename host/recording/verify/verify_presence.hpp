#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/bus/absence.hpp"
#include "common/bus/notes.hpp"
#include "host/recording/set_clocks.hpp"

namespace roadbalance {

/// Notes of a record -> the stretches in which nodes did not measure though they should.
class PresenceCheck {
 public:
  /// In the record's order.
  void take(const Note& note);
  /// Something was recorded at this time.
  void take_time(std::int64_t utc_us);

  /// By node; what lasts does so to the stop, or to the record's end.  A node that is not heard in the end
  /// and has sent its end since was only cut off: its rest was fetched.
  /// @param ended  the last epoch of each of these nodes has its end in the record
  std::vector<Absence> absences(const std::set<std::int32_t>& ended) const;
  /// "node 2 (rear) never came"
  std::string sentence(const Absence& absence) const;

 private:
  using Stamp = SetClocks::Stamp;
  /// An absence without its instants.
  struct Stretch {
    Absence absence{};
    Stamp since{}, until{};
  };
  struct Node {
    std::vector<Stretch> past{};
    bool is_missing = false;
    Stretch now{};
    std::string name{};
  };
  std::string name_of(std::int32_t node) const;
  Absence absence_of(const Stretch& stretch, const Stamp& until) const;

  SetClocks clocks_;
  std::map<std::int32_t, Node> node_;
  Stamp stopped_{}, last_{};  // 0: not known
};

}  // namespace roadbalance
