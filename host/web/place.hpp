#pragma once

#include <cstddef>
#include <utility>

namespace roadbalance {

/// Its place among those that are allowed at a time.
class Place {
 public:
  explicit Place(std::size_t& taken) : taken_(&taken) { ++*taken_; }
  Place(Place&& other) noexcept : taken_(std::exchange(other.taken_, nullptr)) {}
  Place& operator=(Place&&) = delete;
  ~Place() {
    if (taken_) --*taken_;
  }

 private:
  std::size_t* taken_;
};

}  // namespace roadbalance
