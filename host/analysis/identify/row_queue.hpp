#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <memory>
#include <memory_resource>
#include <vector>

#include "host/analysis/identify/grid.hpp"

namespace roadbalance {

/// Rows of a node that wait for another node's: half an hour of them if its cable was pulled, 240 MB.
///
/// Memory holds no more than kInMemory at the front and two batches at the back; what lies between is in an
/// unnamed file of the folder for temporary ones, or in memory after all where there can be none.
class RowQueue {
 public:
  static constexpr std::size_t kBatch = 1024, kInMemory = 4 * kBatch;

  RowQueue() = default;
  RowQueue(RowQueue&&) = default;
  RowQueue& operator=(RowQueue&&) = delete;  // its memory would go before the rows in it

  void push_back(const GridRows& rows);
  bool empty() const { return front_.empty(); }
  GridRows& front() { return front_.front(); }
  const GridRows& front() const { return front_.front(); }
  const GridRows& back() const;
  void pop_front();
  void pop_back();
  void clear();

  std::size_t size() const;
  /// Those next to be taken, all of them while they are no more than kInMemory.
  const std::pmr::deque<GridRows>& at_hand() const { return front_; }
  bool uses_file() const { return first_ < last_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  bool write_batch();
  void read_batch(std::int64_t batch);

  /// A row is larger than what a deque asks memory for at a time: each would be asked for and given back.
  std::unique_ptr<std::pmr::unsynchronized_pool_resource> pool_ =
      std::make_unique<std::pmr::unsynchronized_pool_resource>(std::pmr::pool_options{
          .max_blocks_per_chunk = 64, .largest_required_pool_block = 2 * sizeof(GridRows)});
  std::pmr::deque<GridRows> front_{pool_.get()},
      back_{pool_.get()};  ///< the file's between them; no file and no back: all is in front_
  std::unique_ptr<std::FILE, Close> file_;
  std::int64_t first_ = 0, last_ = 0;  ///< batches in the file
  bool no_file_ = false;
  std::vector<GridRows> batch_;
};

}  // namespace roadbalance
