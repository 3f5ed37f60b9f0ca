#pragma once

#include <cstddef>

namespace roadbalance::test {

/// While it lives, this thread must not touch the heap: at its end every allocation made meanwhile is a test
/// failure.
///
/// Counts operator new and, as Eigen's matrices come from there, malloc and its kin called from our own
/// objects (the linker's --wrap; see CMakeLists.txt).  Other threads may allocate.
class NoAllocation {
 public:
  NoAllocation();
  NoAllocation(const NoAllocation&) = delete;
  NoAllocation& operator=(const NoAllocation&) = delete;
  ~NoAllocation();

  /// Allocations of this thread since the guard was made or last forgave.
  std::size_t count() const;
  /// Takes what happened so far as allowed.
  void forgive();

 private:
  std::size_t before_;
};

}  // namespace roadbalance::test
