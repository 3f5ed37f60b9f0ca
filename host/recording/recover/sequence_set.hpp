#pragma once

#include <cstdint>
#include <iterator>
#include <map>

namespace roadbalance {

/// A set of numbers that mostly follow one another: its size grows with the runs, not with the numbers.
class SequenceSet {
 public:
  /// False if the number is in already.
  bool insert(std::int64_t number) {
    auto next = runs_.upper_bound(number);
    if (next != runs_.begin()) {
      const auto before = std::prev(next);
      if (before->second >= number) return false;
      if (before->second == number - 1) {
        before->second = number;
        join(before, next);
        return true;
      }
    }
    join(runs_.emplace_hint(next, number, number), next);
    return true;
  }

 private:
  using Runs = std::map<std::int64_t, std::int64_t>;  // first -> last

  void join(Runs::iterator run, Runs::iterator next) {
    if (next == runs_.end() || next->first != run->second + 1) return;
    run->second = next->second;
    runs_.erase(next);
  }

  Runs runs_;
};

}  // namespace roadbalance
